from __future__ import annotations

import threading

from tool0.installation.ros1.apt import commands as ask
from tool0.runtime.mailbox import Mailbox


def test_letters_come_out_in_the_order_they_went_in() -> None:
    mailbox = Mailbox()
    assert not mailbox
    futures = [mailbox.post(ask.Step(n)) for n in range(1, 4)]
    assert mailbox
    taken = [mailbox.take() for _ in futures]
    assert [letter[0] for letter in taken if letter] == [ask.Step(n) for n in (1, 2, 3)]
    assert [letter[1] for letter in taken if letter] == futures
    assert not mailbox


def test_an_empty_mailbox_gives_none_with_and_without_waiting() -> None:
    mailbox = Mailbox()
    assert mailbox.take() is None
    assert mailbox.take(timeout=0.001) is None


def test_a_reader_that_waits_is_woken_by_a_letter() -> None:
    mailbox = Mailbox()
    got: list[object] = []
    reader = threading.Thread(target=lambda: got.append(mailbox.take(timeout=30.0)))
    reader.start()
    future = mailbox.post(ask.SetPaused(True))
    reader.join(30.0)
    assert got == [(ask.SetPaused(True), future)]


def test_no_letter_of_many_writers_is_lost() -> None:
    mailbox = Mailbox()

    def write(start: int) -> None:
        for n in range(100):
            mailbox.post(ask.Step(start + n))

    writers = [threading.Thread(target=write, args=(100 * k,)) for k in range(8)]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join()
    found = []
    while (letter := mailbox.take()) is not None:
        found.append(letter[0])
    assert sorted(step.ticks for step in found) == list(range(800))  # type: ignore[union-attr]
