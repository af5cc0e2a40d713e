"""docs/reference/requests.md is what tools/request_docs.py makes of the contract."""

import pytest
from tools.request_docs import DOCUMENT, document

from tool0.protocol.methods import contract

pytestmark = pytest.mark.slow


def test_the_document_is_generated_from_the_contract_as_it_is() -> None:
    assert DOCUMENT.read_text(encoding="utf-8") == document(), (
        "run: .venv/bin/python tools/request_docs.py"
    )


def test_every_request_and_each_of_its_fields_is_in_the_document() -> None:
    text = document()
    for name, request in contract().items():
        _, found, rest = text.partition(f"### `{name}`\n")
        assert found, name
        section = rest.partition("\n### ")[0]
        for field in request.__struct_fields__:
            assert f"| `{field}` |" in section, (name, field)
