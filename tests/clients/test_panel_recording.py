"""A page downloads what was recorded, and sees it replayed."""

import urllib.request
from pathlib import Path
from urllib.error import HTTPError

import pytest
from browser import Tab, eventually

import tool0
from conftest import OpenTab
from tool0.panel.server import Panel


def fetch(panel: Panel, path: str, **headers: str) -> bytes:
    method = "POST" if path.endswith("replay") else "GET"
    url = panel.url.rstrip("/") + path
    request = urllib.request.Request(url, method=method, headers=headers)
    with urllib.request.urlopen(request) as answer:
        body: bytes = answer.read()
    return body


def test_only_a_recording_that_was_completed_is_there(
    panel: Panel, robot: tool0.Robot, tmp_path: Path
) -> None:
    def refused(path: str, **headers: str) -> int:
        with pytest.raises(HTTPError) as caught:
            fetch(panel, path, **headers)
        caught.value.close()
        return caught.value.code

    assert refused("/recording") == 404
    assert refused("/recording/replay") == 404
    file = tmp_path / "taken.mcap"
    robot.start_recording(file)
    assert refused("/recording") == 404
    robot.stop_recording()
    assert fetch(panel, "/recording") == file.read_bytes()
    assert refused("/recording/replay", Origin="http://example.com") == 403
    file.unlink()
    assert refused("/recording") == 404


def test_after_a_recording_the_page_offers_replay_and_download(
    panel: Panel, robot: tool0.Robot, open_tab: OpenTab
) -> None:
    tab: Tab = open_tab(panel.url)
    tab.get("record-start").click()
    tab.get("record-stop").click()
    tab.text("notice", ".mcap")
    with tab.page.expect_download() as download:
        tab.get("notice-download").click()
    assert download.value.suggested_filename.endswith(".mcap")
    eventually(lambda: Path(download.value.path()).stat().st_size > 0, "it is there")
    with tab.context.expect_page() as opened:
        tab.get("notice-replay").click()
    replay = opened.value
    replay.wait_for_url("http://127.0.0.1:*/**")
    replay.get_by_test_id("timeline-loop").wait_for()
    replay.close()
