"""The mailbox of the thread that ticks."""

from __future__ import annotations

import threading

import pytest

from tool0.simulation.mailbox import Mailbox


def test_items_come_in_order() -> None:
    mailbox: Mailbox[int] = Mailbox()
    for item in range(3):
        mailbox.put(item)
    assert len(mailbox) == 3
    assert [mailbox.take() for _ in range(4)] == [[0], [1], [2], []]


@pytest.mark.timeout(30)
def test_a_wait_ends_also_if_its_time_is_over_before_it_begins() -> None:
    """``queue.SimpleQueue.get`` then waits forever."""
    mailbox: Mailbox[int] = Mailbox()
    for _ in range(2000):
        mailbox.put(0)
        mailbox.take()
        mailbox.wait(1e-7)
        mailbox.wait(1e-7)
    assert not mailbox.take()


def test_what_another_thread_puts_ends_a_wait() -> None:
    mailbox: Mailbox[str] = Mailbox()
    begun = threading.Event()

    def put() -> None:
        begun.wait()
        mailbox.put("it")

    thread = threading.Thread(target=put)
    thread.start()
    begun.set()
    mailbox.wait(60.0)
    assert mailbox.take() == ["it"]
    thread.join()
