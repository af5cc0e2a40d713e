"""Pages of other origins and those without the token stay outside."""

import http.client
import socket
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from page import TIMEOUT, page_at, socket_url
from websockets.exceptions import InvalidStatus
from websockets.frames import Frame, Opcode
from websockets.sync.client import connect

import tool0
from tool0.panel.address import TOKEN_VARIABLE, Endpoint, open_endpoint
from tool0.panel.server import Panel, panel_service
from tool0.recording.options import episodes_folder, recordings_folder
from tool0.scene import Pose, Scene, SceneObject, mesh
from tool0.server.server import Server

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
def endpoint() -> Iterator[Endpoint]:
    endpoint = open_endpoint()
    yield endpoint
    endpoint.listener.close()


def fetch(
    panel: Panel, path: str, method: str = "GET", **headers: str
) -> http.client.HTTPResponse:
    """Send a request with exactly these headers; ``body`` is what came."""
    parts = urlsplit(panel.url)
    assert parts.hostname is not None
    connection = http.client.HTTPConnection(parts.hostname, parts.port, timeout=TIMEOUT)
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
        ws.send('{"id": 1, "method": "emergency_stop"}')
    assert refused.value.response.status_code == 403
    assert not robot.snapshot.is_stopped
    assert fetch(panel, "/ws", "POST", Origin=origin).status == 403


@pytest.mark.parametrize(
    "host",
    [
        "evil.example",
        "127.0.0.1",
        "127.0.0.1:1",
        "127.0.0.1.evil.example:8085",
        "127.0.0.1:" + "8" * 5000,
        "",
        "[",
    ],
    ids=lambda host: host[:40],
)
def test_a_name_that_leads_here_but_is_not_ours_is_refused(
    panel: Panel, host: str
) -> None:
    response = fetch(panel, "/", Host=host)
    assert response.status == 421
    with socket.create_connection(
        (urlsplit(panel.url).hostname, urlsplit(panel.url).port), timeout=TIMEOUT
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
        assert page.request("pause") is None
    with page_at(panel.url.replace("127.0.0.1", "localhost")) as page:
        assert page.request("resume") is None
    port = urlsplit(panel.url).port
    assert fetch(panel, "/", Host=f"[::1]:{port}").status == 200


@pytest.mark.parametrize(
    ("frame", "code"),
    [
        (Frame(Opcode.TEXT, b"\xff\xfe"), 1007),
        (Frame(Opcode.CONT, b"x"), 1002),
        (Frame(Opcode.CLOSE, b"\x00"), 1002),
        (Frame(Opcode.TEXT, b"x" * 70_000), 1009),
    ],
    ids=lambda value: str(value)[:20],
)
def test_a_bad_frame_ends_its_connection_and_prints_nothing(
    panel: Panel, frame: Frame, code: int, caplog: pytest.LogCaptureFixture
) -> None:
    with page_at(panel.url) as page:
        page.start("subscribe")  # while it is sent much
        page.socket.socket.sendall(frame.serialize(mask=True))
        assert page.close_code() == code
    assert not caplog.records


def test_a_page_records_only_where_recordings_are(
    robot: tool0.Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    recordings, allowed = recordings_folder(), tmp_path / "allowed"
    for folder in (recordings, allowed):
        folder.mkdir(parents=True)
    (recordings / "link").symlink_to(tmp_path)
    endpoint = open_endpoint(port=0)
    backend, service = panel_service(robot, endpoint, allowed)
    with Server(backend, [service]), page_at(service.url) as page:
        for file in (
            "x.mcap",
            f"{tmp_path}/x.mcap",
            f"{recordings}/../x.mcap",
            f"{recordings}/link/x.mcap",
            f"{recordings}/link/../x.mcap",
            f"{recordings}/\0.mcap",
            "~nobody-of-this-name/x.mcap",
        ):
            error = page.request("start_recording", file=file)
            assert error is not None
            assert "--panel-folder" in error["message"], file
        error = page.request("open_episodes", folder=f"{tmp_path}/lift")
        assert error is not None
        assert str(episodes_folder()) in error["message"]
        assert {path.name for path in tmp_path.iterdir()} == {"data", "allowed"}
        for file in (None, f"{recordings}/x.mcap", f"{allowed}/x.mcap"):
            assert page.request("start_recording", file=file) is None
            assert page.request("stop_recording") is None
        assert page.request("open_episodes", folder=f"{episodes_folder()}/a") is None
        assert page.request("close_episodes") is None


TETRAHEDRON = """\
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
f 1 3 2
f 1 2 4
f 1 4 3
f 2 3 4
"""
MODEL = (
    '<robot name="part"><link name="part"><inertial><mass value="1"/>'
    '<inertia ixx="1" iyy="1" izz="1"/></inertial><collision><geometry>'
    '<mesh filename="{}"/></geometry></collision></link></robot>'
)
SDF = (
    '<sdf version="1.6"><model name="part"><link name="part"><collision name="c">'
    "<geometry><mesh><uri>{}</uri></mesh></geometry></collision></link></model></sdf>"
)


def test_a_page_has_only_files_read_that_the_robot_knows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    own, allowed = tmp_path / "own", tmp_path / "allowed"
    for folder in (own, allowed, tmp_path / "ros" / "parts"):
        folder.mkdir(parents=True)
        for name in ("known.obj", "secret.obj"):
            (folder / name).write_text(TETRAHEDRON)
    (allowed / "link.obj").symlink_to(own / "secret.obj")
    (tmp_path / "ros" / "parts" / "package.xml").write_text("<name>parts</name>")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "ros"))
    known, secret = f"{own}/known.obj", f"{own}/secret.obj"
    at = Pose(xyz=(1.0, 1.0, 1.0))
    part = SceneObject(name="part", geometry=mesh(known, 0.01), pose=at)
    endpoint = open_endpoint(port=0)

    def shape(file: str) -> dict[str, object]:
        return {"kind": "mesh", "file": file, "scale": [0.01, 0.01, 0.01]}

    with tool0.bringup(scene=Scene((part,)), realtime=False) as robot:
        backend, service = panel_service(robot, endpoint, allowed)
        with Server(backend, [service]), page_at(service.url) as page:
            for file in (
                secret,
                f"file://{secret}",
                f"{allowed}/../own/secret.obj",
                f"{allowed}/link.obj",
                "package://parts/../../own/secret.obj",
                f"{allowed}/\0.obj",
                "ftp://secret.obj",
            ):
                parts = [{"shape": shape(file)}]
                for params in (
                    {"shape": shape(file)},
                    {"shape": {"kind": "compound", "parts": parts}},
                ):
                    error = page.request("add_object", name="a", **params)
                    assert error is not None
                    assert "a page reads only files of ROS packages" in error["message"]
            for model in (MODEL.format(secret), SDF.format(secret)):
                error = page.request("add_model", name="a", model=model)
                assert error is not None
                assert "a page reads only" in error["message"]
            error = page.request("load_controller", name="a", files=["/etc/passwd"])
            assert error is not None
            assert "a page reads only" in error["message"]
            assert page.request("remove_object", name="part") is None
            for number, file in enumerate(
                (known, f"{allowed}/secret.obj", "package://parts/secret.obj")
            ):
                place = {"name": f"a{number}", "xyz": [1.0, float(number), 1.0]}
                assert page.request("add_object", shape=shape(file), **place) is None
        robot.scene.add("b", mesh(secret, 0.01), xyz=(2.0, 0.0, 1.0))


def test_a_chosen_token_is_needed(robot: tool0.Robot) -> None:
    with Panel(robot, port=0, token="open sesame") as panel:
        bare = origin_of(panel)
        assert panel.url == f"{bare}/?token=open%20sesame"
        with page_at(panel.url) as page:
            assert page.request("pause") is None
        for query in ("", "?token=", "?token=open", "?token=open%20sesame&token=x"):
            with (
                pytest.raises(InvalidStatus) as refused,
                connect(socket_url(f"{bare}/{query}")),
            ):
                pass
            assert refused.value.response.status_code == 401
            for path in ("/robot.urdf", "/meshes/0.stl"):
                assert fetch(panel, path + query).status == 401
        for path in ("/robot.urdf", "/meshes/0.stl"):
            assert fetch(panel, path + "?token=open+sesame").status == 200
        assert fetch(panel, "/").status == 200


@pytest.mark.parametrize("host", [None, "127.0.0.1", "localhost"])
def test_on_the_loopback_a_token_comes_from_the_environment_or_there_is_none(
    monkeypatch: pytest.MonkeyPatch, host: str | None
) -> None:
    endpoint = open_endpoint(host, port=0)
    endpoint.listener.close()
    assert endpoint.token is None
    assert "token" not in endpoint.url
    monkeypatch.setenv(TOKEN_VARIABLE, "mine")
    endpoint = open_endpoint(host, port=0)
    endpoint.listener.close()
    assert endpoint.token == "mine"


def test_beyond_the_loopback_there_is_always_a_token(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tokens = []
    for _ in range(2):
        endpoint = open_endpoint("0.0.0.0", port=0)
        tokens.append(endpoint.token or "")
        endpoint.listener.close()
    assert tokens[0] != tokens[1]
    assert min(map(len, tokens)) >= 20
    monkeypatch.setenv(TOKEN_VARIABLE, "mine")
    endpoint = open_endpoint("0.0.0.0", port=0)
    endpoint.listener.close()
    assert endpoint.token == "mine"


def test_by_default_only_this_machine_comes_in(endpoint: Endpoint) -> None:
    assert endpoint.token is None
    assert endpoint.listener.getsockname()[0] == "127.0.0.1"
    assert endpoint.is_known_as(f"LocalHost:{endpoint.port}")
    assert not endpoint.is_known_as(f"192.0.2.1:{endpoint.port}")


def test_open_to_all_any_address_is_ours_but_no_foreign_name() -> None:
    endpoint = open_endpoint("0.0.0.0", 0)
    endpoint.listener.close()
    assert endpoint.token is not None
    assert socket.gethostname() in endpoint.url
    for name in ("192.0.2.1:80", "[2001:db8::1]:9", "localhost", socket.gethostname()):
        assert endpoint.is_known_as(name), name
    for name in ("evil.example", "", "192.0.2.1.evil.example:80"):
        assert not endpoint.is_known_as(name), name


def test_what_is_served_may_do_little(panel: Panel) -> None:
    response = fetch(panel, "/")
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
    response = fetch(panel, path)
    assert response.status in (307, 404), path


def test_only_reading_is_served(panel: Panel) -> None:
    for method in ("POST", "PUT", "DELETE"):
        assert fetch(panel, "/robot.urdf", method).status == 405


def test_the_built_page_is_kept_by_browsers_and_its_index_is_not(
    robot: tool0.Robot,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    static = tmp_path_factory.mktemp("static")
    monkeypatch.setattr("tool0.panel.server.STATIC", static)
    with Panel(robot) as panel:
        response = fetch(panel, "/")
        assert response.headers["content-type"].startswith("text/plain")
        assert "make run" in response.body.decode()  # type: ignore[attr-defined]
    (static / "assets").mkdir()
    (static / "index.html").write_text(HTML)
    (static / "assets" / "index-1a2b.js").write_text("let x = 1;\n" * 500)
    with Panel(robot) as panel:
        response = fetch(panel, "/")
        assert response.body.decode() == HTML  # type: ignore[attr-defined]
        assert response.headers["cache-control"] == "no-cache"
        response = fetch(panel, "/assets/index-1a2b.js", Accept_Encoding="gzip")
        assert "immutable" in response.headers["cache-control"]
        assert response.headers["content-encoding"] == "gzip"
        assert "javascript" in response.headers["content-type"]
        assert "immutable" not in fetch(panel, "/assets/x.js").headers.get(
            "cache-control", ""
        )
