"""Pages of other origins and those without the token stay outside."""

import http.client
import socket
from collections.abc import Iterator
from urllib.parse import urlsplit

import pytest
from page import page_at, socket_url
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

import tool0
from tool0.interfaces.panel.address import TOKEN_VARIABLE, Door, open_door
from tool0.interfaces.panel.server import Panel

HTML = "<!doctype html><title>Panel</title>"


@pytest.fixture(scope="module")
def robot() -> Iterator[tool0.Robot]:
    """Bring one up for all tests here: none of them drives it."""
    with tool0.bringup() as robot:
        yield robot


@pytest.fixture(scope="module")
def panel(robot: tool0.Robot) -> Iterator[Panel]:
    with Panel(robot) as panel:
        yield panel


@pytest.fixture
def door() -> Iterator[Door]:
    door = open_door()
    yield door
    door.listener.close()


def ask(
    panel: Panel, path: str, method: str = "GET", **headers: str
) -> http.client.HTTPResponse:
    """Ask the server with exactly these headers, and leave the answer readable."""
    parts = urlsplit(panel.url)
    assert parts.hostname is not None
    connection = http.client.HTTPConnection(parts.hostname, parts.port, timeout=10.0)
    connection.putrequest(
        method, path, skip_host="Host" in headers, skip_accept_encoding=True
    )
    for name, value in headers.items():
        connection.putheader(name.replace("_", "-"), value)
    connection.endheaders()
    response = connection.getresponse()
    response.body = response.read()  # type: ignore[attr-defined]
    connection.close()
    return response


def origin_of(panel: Panel) -> str:
    return panel.url.partition("/?")[0].rstrip("/")


@pytest.mark.parametrize(
    "origin",
    [
        "http://evil.example",
        "https://evil.example:8085",
        "null",
        "http://127.0.0.1",
        "",
    ],
)
def test_a_page_on_another_origin_cannot_drive_the_robot(
    panel: Panel, robot: tool0.Robot, origin: str
) -> None:
    url = socket_url(panel.url)
    headers = {"Origin": origin}
    with (
        pytest.raises(InvalidStatus) as refused,
        connect(url, additional_headers=headers) as ws,
    ):
        ws.send('{"type": "emergency_stop", "id": 1, "engaged": true}')
    assert refused.value.response.status_code == 403
    assert not robot.snapshot.is_stopped
    assert ask(panel, "/ws", "POST", Origin=origin).status == 403


@pytest.mark.parametrize(
    "host",
    [
        "evil.example",
        "127.0.0.1",
        "127.0.0.1:1",
        "127.0.0.1.evil.example:8085",
        "",
        "[",
    ],
)
def test_a_name_that_leads_here_but_is_not_ours_is_refused(
    panel: Panel, host: str
) -> None:
    response = ask(panel, "/", Host=host)
    assert response.status == 421
    with socket.create_connection(
        (urlsplit(panel.url).hostname, urlsplit(panel.url).port), timeout=10.0
    ) as ws:
        ws.sendall(
            f"GET /ws HTTP/1.1\r\nHost: {host}\r\nUpgrade: websocket\r\n"
            f"Connection: Upgrade\r\nOrigin: http://{host}\r\n"
            "Sec-WebSocket-Version: 13\r\n"
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n".encode()
        )
        assert ws.recv(100).startswith(b"HTTP/1.1 421")


def test_our_own_page_and_programs_come_in(panel: Panel) -> None:
    with page_at(panel.url, origin=origin_of(panel)) as page:
        assert page.ask("pause") is None
    with page_at(panel.url.replace("127.0.0.1", "localhost")) as page:
        assert page.ask("resume") is None
    port = urlsplit(panel.url).port
    assert ask(panel, "/", Host=f"[::1]:{port}").status == 200


def test_a_chosen_port_needs_the_token(robot: tool0.Robot) -> None:
    with Panel(robot, port=0, token="open sesame") as panel:
        bare = origin_of(panel)
        assert panel.url == f"{bare}/?token=open%20sesame"
        with page_at(panel.url) as page:
            assert page.ask("pause") is None
        for query in ("", "?token=", "?token=open", "?token=open%20sesame&token=x"):
            with (
                pytest.raises(InvalidStatus) as refused,
                connect(socket_url(f"{bare}/{query}")),
            ):
                pass
            assert refused.value.response.status_code == 401
            for path in ("/robot.urdf", "/meshes/0.stl"):
                assert ask(panel, path + query).status == 401
        for path in ("/robot.urdf", "/meshes/0.stl"):
            assert ask(panel, path + "?token=open+sesame").status == 200
        assert ask(panel, "/").status == 200


def test_a_token_comes_from_the_environment_or_by_chance(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tokens = []
    for _ in range(2):
        door = open_door(port=0)
        tokens.append(door.token or "")
        door.listener.close()
    assert tokens[0] != tokens[1]
    assert min(map(len, tokens)) >= 20
    monkeypatch.setenv(TOKEN_VARIABLE, "mine")
    door = open_door("127.0.0.1")
    door.listener.close()
    assert door.token == "mine"


def test_by_default_only_this_machine_comes_in(door: Door) -> None:
    assert door.token is None
    assert door.listener.getsockname()[0] == "127.0.0.1"
    assert door.is_known_as(f"LocalHost:{door.port}")
    assert not door.is_known_as(f"192.0.2.1:{door.port}")


def test_open_to_all_any_address_is_ours_but_no_foreign_name() -> None:
    door = open_door("0.0.0.0", 0)
    door.listener.close()
    assert door.token is not None
    assert socket.gethostname() in door.url
    for name in ("192.0.2.1:80", "[2001:db8::1]:9", "localhost", socket.gethostname()):
        assert door.is_known_as(name), name
    for name in ("evil.example", "", "192.0.2.1.evil.example:80"):
        assert not door.is_known_as(name), name


def test_what_is_served_may_do_little(panel: Panel) -> None:
    response = ask(panel, "/")
    policy = response.headers["content-security-policy"]
    assert "default-src 'self'" in policy
    assert "unsafe" not in policy
    assert "frame-ancestors 'none'" in policy
    assert response.headers["x-content-type-options"] == "nosniff"
    assert response.headers["referrer-policy"] == "no-referrer"
    assert response.headers["cross-origin-opener-policy"] == "same-origin"
    assert "access-control-allow-origin" not in response.headers
    assert "server" not in response.headers


@pytest.mark.parametrize(
    "path",
    [
        "/meshes/../../../../etc/passwd",
        "/meshes/..%2f..%2f..%2fetc%2fpasswd",
        "/meshes//etc/passwd",
        "/assets/../server.py",
        "/assets/..%2fserver.py",
        "/assets/%2e%2e/%2e%2e/server.py",
        "/server.py",
        "/meshes/999.stl",
        "/meshes/0.stl/",
        "//etc/passwd",
    ],
)
def test_no_path_leads_to_a_file_that_is_not_served(panel: Panel, path: str) -> None:
    response = ask(panel, path)
    assert response.status in (307, 404), path


def test_only_reading_is_served(panel: Panel) -> None:
    for method in ("POST", "PUT", "DELETE"):
        assert ask(panel, "/robot.urdf", method).status == 405


def test_the_built_page_is_kept_by_browsers_and_its_index_is_not(
    robot: tool0.Robot,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    static = tmp_path_factory.mktemp("static")
    monkeypatch.setattr("tool0.interfaces.panel.server.STATIC", static)
    with Panel(robot) as panel:
        response = ask(panel, "/")
        assert response.headers["content-type"].startswith("text/plain")
        assert "make run" in response.body.decode()  # type: ignore[attr-defined]
    (static / "assets").mkdir()
    (static / "index.html").write_text(HTML)
    (static / "assets" / "index-1a2b.js").write_text("let x = 1;\n" * 500)
    with Panel(robot) as panel:
        response = ask(panel, "/")
        assert response.body.decode() == HTML  # type: ignore[attr-defined]
        assert response.headers["cache-control"] == "no-cache"
        response = ask(panel, "/assets/index-1a2b.js", Accept_Encoding="gzip")
        assert "immutable" in response.headers["cache-control"]
        assert response.headers["content-encoding"] == "gzip"
        assert "javascript" in response.headers["content-type"]
        assert "immutable" not in ask(panel, "/assets/x.js").headers.get(
            "cache-control", ""
        )
