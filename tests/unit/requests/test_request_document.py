"""docs/requests.md is what tools/request_docs.py makes of the table."""

from tools.request_docs import DOCUMENT, document

from tool0.requests.table import entries


def test_the_document_is_generated_from_the_table_as_it_is() -> None:
    assert DOCUMENT.read_text(encoding="utf-8") == document(), (
        "run: .venv/bin/python tools/request_docs.py"
    )


def test_every_request_and_each_of_its_fields_is_in_the_document() -> None:
    text = document()
    ours = {n: e for n, e in entries().items() if e.request.__module__[:5] == "tool0"}
    for name, entry in ours.items():
        _, found, rest = text.partition(f"### `{name}`\n")
        assert found, name
        section = rest.partition("\n### ")[0]
        for field in entry.request.__struct_fields__:
            assert f"| `{field}` |" in section, (name, field)
