import contextlib
import os
import subprocess
import sys
import threading
from pathlib import Path

import fresh_python
import pytest
import xacro

from tool0.description.expansion import expand
from tool0.description.xml_source import locate
from tool0.errors import DescriptionError


def write(folder: Path, name: str, body: str) -> Path:
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    path.write_text(
        '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="r">\n'
        f"{body}\n</robot>"
    )
    return path


def links(path: Path, **args: str) -> list[str]:
    document = expand(path, args).document
    return [link.getAttribute("name") for link in document.getElementsByTagName("link")]


def failure(path: Path, **args: str) -> str:
    with pytest.raises(DescriptionError) as caught:
        expand(path, args)
    return str(caught.value)


def test_dirname_is_the_folder_of_the_file_it_is_written_in(tmp_path: Path) -> None:
    write(tmp_path, "sub/inner.xacro", '<link name="$(dirname)"/>')
    path = write(
        tmp_path,
        "outer.xacro",
        '<xacro:include filename="$(dirname)/sub/inner.xacro"/>'
        '<link name="$(dirname)"/>',
    )
    assert links(path) == [str(tmp_path / "sub"), str(tmp_path)]


def test_find_reaches_bundled_packages_and_those_of_the_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "cell"
    package.mkdir()
    (package / "package.xml").write_text("<package><name>my_cell</name></package>")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    path = write(
        tmp_path, "a.xacro", '<link name="$(find my_cell)/$(find tool0_description)"/>'
    )
    (name,) = links(path)
    assert name.startswith(f"{package}/")
    assert name.endswith("tool0_description")


def test_every_substitution_of_ros_works(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CELL", "c")
    monkeypatch.delenv("NOWHERE", raising=False)
    path = write(
        tmp_path,
        "a.xacro",
        '<xacro:arg name="n" default="2"/>\n'
        '<xacro:property name="p" value="${$(arg n) * 3}"/>\n'
        '<link name="$(arg n)|${p}|$(env CELL)|$(optenv CELL d)|$(optenv NOWHERE d e)'
        '|$(eval n + 1)|$$(arg n)|$${p}|5$"/>',
    )
    assert links(path) == ["2|6|c|c|d e|3|$(arg n)|${p}|5$"]
    assert links(path, n="4") == ["4|12|c|c|d e|5|$(arg n)|${p}|5$"]


def test_types_survive_expressions(tmp_path: Path) -> None:
    path = write(
        tmp_path,
        "a.xacro",
        '<xacro:property name="items" value="${[1, 2.5]}"/>'
        '<xacro:if value="${len(items) == 2}"><link name="${items[1] * 2}"/></xacro:if>'
        '<xacro:unless value="${items[0] == 1}"><link name="no"/></xacro:unless>',
    )
    assert links(path) == ["5.0"]


def test_yaml_is_read_with_units_and_relative_to_its_reader(tmp_path: Path) -> None:
    (tmp_path / "p.yaml").write_text("a: !degrees 180\nb: {c: [1, {d: x}]}\n")
    path = write(
        tmp_path,
        "a.xacro",
        "<xacro:property name='y' value=\"${xacro.load_yaml('p.yaml')}\"/>"
        '<link name="${y.a}|${y.b.c[1].d}"/>',
    )
    assert links(path) == ["3.141592653589793|x"]


def test_an_optional_include_may_be_missing(tmp_path: Path) -> None:
    path = write(
        tmp_path,
        "a.xacro",
        '<xacro:include filename="no.xacro" optional="true"/><link name="a"/>',
    )
    assert links(path) == ["a"]


def test_elements_of_a_macro_keep_the_line_of_its_file(tmp_path: Path) -> None:
    macros = write(
        tmp_path,
        "m.xacro",
        '<xacro:macro name="m" params="n *block">\n\n<link name="${n}">\n'
        '<xacro:insert_block name="block"/></link></xacro:macro>',
    )
    path = write(
        tmp_path,
        "a.xacro",
        '<xacro:include filename="m.xacro"/>\n\n\n<xacro:m n="x">\n<visual/></xacro:m>',
    )
    document = expand(path).document
    link = document.getElementsByTagName("link")[0]
    visual = document.getElementsByTagName("visual")[0]
    assert str(locate(link)) == f"{macros}:4"
    assert str(locate(visual)) == f"{path}:6"


@pytest.mark.parametrize(
    ("body", "line", "names"),
    [
        ('\n<link name="${nowhere}"/>', 3, "'nowhere'"),
        ('<link name="${1 +}"/>', 2, "'1 +'"),
        ('<link name="$(find no_such_package)"/>', 2, "ROS_PACKAGE_PATH"),
        ('\n\n<link name="$(arg no)"/>', 4, "'no'"),
        ('<link name="$(env NO_SUCH_VARIABLE)"/>', 2, "$(optenv"),
        ('<link name="$(anon x)"/>', 2, "$(anon x)"),
        ('<link name="$(find)"/>', 2, "'find'"),
        ("\n<xacro:unknown/>", 3, "xacro:unknown"),
        ('\n<xacro:include filename="no.xacro"/>', 3, "no.xacro"),
        ('<xacro:if value="maybe"/>', 2, "maybe"),
        ("<link name=\"${xacro.load_yaml('no.yaml')}\"/>", 2, "no.yaml"),
        ('<link name="${().__class__}"/>', 2, "__class__"),
        ('<xacro:macro name="m"><xacro:m/></xacro:macro>\n<xacro:m/>', 2, "'m'"),
    ],
)
def test_errors_name_the_line(tmp_path: Path, body: str, line: int, names: str) -> None:
    path = write(tmp_path, "a.xacro", body)
    with pytest.raises(DescriptionError) as caught:
        expand(path)
    assert names in str(caught.value)
    assert str(caught.value.location) == f"{path}:{line}"


def test_an_error_tells_macro_and_includes(tmp_path: Path) -> None:
    inner = write(
        tmp_path,
        "inner.xacro",
        '<xacro:macro name="m" params="n">\n<link name="${n + no}"/></xacro:macro>\n'
        '<xacro:m n="x"/>',
    )
    outer = write(tmp_path, "outer.xacro", '<xacro:include filename="inner.xacro"/>')
    text = failure(outer)
    assert text.startswith(f"{inner}:3: ")
    assert f"in macro 'm', {inner}:2" in text
    assert f"included from {outer}" in text


def test_broken_yaml_and_broken_includes_are_located_in_their_own_file(
    tmp_path: Path,
) -> None:
    (tmp_path / "p.yaml").write_text("a: 1\nb: [1,\n")
    body = "<xacro:property name='y' value=\"${xacro.load_yaml('p.yaml')}\"/>${y}"
    assert failure(write(tmp_path, "a.xacro", body)).startswith(f"{tmp_path}/p.yaml:")
    (tmp_path / "bad.xml").write_text("<robot>\n<link>\n</robot>")
    include = write(tmp_path, "b.xacro", '<xacro:include filename="bad.xml"/>')
    assert failure(include).startswith(f"{tmp_path}/bad.xml:3: ")


def test_an_argument_that_no_file_reads_is_refused(tmp_path: Path) -> None:
    path = write(
        tmp_path, "a.xacro", '<xacro:arg name="height" default="1"/><link name="a"/>'
    )
    assert "'height'" in failure(path, hight="2")
    assert links(path, height="2") == ["a"]


def test_an_argument_may_be_read_without_being_declared(tmp_path: Path) -> None:
    assert links(write(tmp_path, "a.xacro", '<link name="$(arg n)"/>'), n="x") == ["x"]


def test_nothing_is_printed(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    path = write(
        tmp_path,
        "a.xacro",
        "<xacro:property name='pi' value='3'/>${xacro.warning('careful')}"
        "${load_yaml('p.yaml')}<link name='a'/>",
    )
    (tmp_path / "p.yaml").write_text("a: 1")
    assert links(path) == ["a"]
    assert capfd.readouterr() == ("", "")
    assert "careful" in caplog.text


@pytest.mark.parametrize("body", ['<link name="a"/>', '<link name="${no}"/>'])
def test_xacro_is_left_as_it_was(tmp_path: Path, body: str) -> None:
    before = dict(vars(xacro))
    path = write(tmp_path, "a.xacro", body)
    with contextlib.suppress(DescriptionError):
        expand(path)
    assert {name: vars(xacro)[name] for name in before} == before


def test_threads_do_not_disturb_each_other(tmp_path: Path) -> None:
    path = write(
        tmp_path,
        "a.xacro",
        '<xacro:macro name="m" params="i"><xacro:if value="${i > 0}">'
        '<link name="$(arg n)${i}"/><xacro:m i="${i - 1}"/></xacro:if></xacro:macro>'
        '<xacro:m i="20"/>',
    )
    found: dict[str, list[str]] = {}

    def work(name: str) -> None:
        for _ in range(5):
            found[name] = links(path, n=name)

    threads = [threading.Thread(target=work, args=(name,)) for name in "abcd"]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == {name: [f"{name}{i}" for i in range(20, 0, -1)] for name in "abcd"}


WARNING_IMPORT = """
import sys, warnings

class Warning:
    def find_spec(self, name, path=None, target=None):
        if name == "xacro":
            warnings.warn("as Python 3.10 does", DeprecationWarning)

sys.meta_path.insert(0, Warning())
from tool0.description.loading import load_description
from tool0.description.config import DescriptionConfig
print(len(load_description(DescriptionConfig()).model.joints) > 6)
"""


def test_warnings_of_xacro_s_import_are_no_errors() -> None:
    assert fresh_python.run(WARNING_IMPORT) == "True\n"


def test_the_robots_name_may_be_an_argument_with_a_default(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf.xacro"
    path.write_text(
        '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="$(arg name)_robot">\n'
        '<xacro:arg name="name" default="ur"/><link name="$(arg name)"/></robot>'
    )
    for args, expected in (({}, "ur"), ({"name": "left"}, "left")):
        robot = expand(path, args).document.documentElement
        assert robot is not None
        assert robot.getAttribute("name") == f"{expected}_robot"
        assert links(path, **args) == [expected]


def test_a_sourced_ros_does_not_replace_the_expander(tmp_path: Path) -> None:
    """ROS puts its own xacro, of any version, first in the path."""
    (tmp_path / "xacro.py").write_text("raise RuntimeError")
    path = write(tmp_path, "robot.xacro", '<link name="a"/>')
    code = (
        "from pathlib import Path\n"
        "from tool0.description.expansion import expand\n"
        f"print(expand(Path({str(path)!r})).document.documentElement.tagName)"
    )
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", code],
        check=False,
        env=environment,
        capture_output=True,
        text=True,
    )
    assert done.stdout.strip() == "robot", done.stderr


def test_the_values_of_arguments_are_given_ones_and_defaults(tmp_path: Path) -> None:
    path = write(
        tmp_path,
        "robot.xacro",
        '<xacro:arg name="a" default="1"/><xacro:arg name="b" default="2"/>'
        '<link name="$(arg a)"/>',
    )
    assert expand(path, {"b": "3"}).arguments == {"a": "1", "b": "3"}


FROM_ARGUMENT = (
    "<xacro:arg name='limits' default=''/><xacro:arg name='other' default='x'/>\n"
    "<xacro:property name='file' value='$(arg limits)'/>\n"
)


@pytest.mark.parametrize(
    "body",
    [
        "<link name='${xacro.load_yaml(file)}'/>",
        "<xacro:include filename='${file}'/>",
    ],
)
def test_an_empty_name_of_a_file_names_the_empty_argument(
    body: str, tmp_path: Path
) -> None:
    path = write(tmp_path, "robot.xacro", FROM_ARGUMENT + body)
    said = failure(path)
    assert "the name of the file is empty, and so is the argument 'limits'; " in said
    assert "give a file, such as limits:=FILE" in said
    assert f"{path}:4: " in said
    assert "and so are the arguments 'limits', 'other'" in failure(path, other="")
    folder = failure(path, limits=".")
    assert f"'{tmp_path}' is a folder; give a file in it" in folder
    assert "Errno" not in failure(path, limits="no.yaml")


def test_an_optional_include_may_have_no_name(tmp_path: Path) -> None:
    body = "<xacro:include filename='${file}' optional='true'/><link name='a'/>"
    assert links(write(tmp_path, "robot.xacro", FROM_ARGUMENT + body)) == ["a"]
