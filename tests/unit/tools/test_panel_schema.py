from panel_schema import SCHEMA, schema_text


def test_the_page_s_schema_is_made_from_the_protocol_as_it_is() -> None:
    assert SCHEMA.read_text(encoding="utf-8") == schema_text(), (
        "the protocol has changed; run `python tools/panel_schema.py`"
    )
