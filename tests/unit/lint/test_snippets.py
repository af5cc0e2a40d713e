"""What a text shows, found at its lines."""

from tool0.lint.snippets import snippets

TEXT = """\
Open the file:

    195 <!-- base link -->
    196 <!-- <link name="a"/>
    197 <joint/> -->

then write

```yaml
arm:
  type: x/YController   # 修改

  joints:
    - a
```

    <launch>
      <!-- two
           lines -->
      <node pkg="a"/>

      <node pkg="b"/>
    </launch>
and <b>this</b> is prose, a < b.
See: https://example.org
<never closed
"""


def test_fragments_are_cut_out_with_their_rows() -> None:
    comments, yaml, launch = snippets(TEXT)
    assert (comments.kind, comments.row) == ("xml", 2)
    assert comments.text.splitlines()[1].strip() == '<!-- <link name="a"/>'
    assert (yaml.kind, yaml.row) == ("yaml", 9)
    assert yaml.text.splitlines()[-1] == "    - a"
    assert (launch.kind, launch.row) == ("xml", 16)
    assert launch.text.startswith("<launch>\n")
    assert launch.text.endswith("</launch>\n")


def test_text_without_any_has_none() -> None:
    assert list(snippets("a\n\nb: c d\n1. x\n- y\n")) == []
