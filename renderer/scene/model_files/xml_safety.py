"""The refusal of XML entities, which may expand without end or name another file."""

from renderer.scene.model_files.record import Unreadable


def refuse_entities(data: bytes) -> None:
    """Raise Unreadable for an XML document that declares entities or a document type."""
    head = data.replace(b"\x00", b"").upper()  # for UTF-16
    if b"<!ENTITY" in head or b"<!DOCTYPE" in head:
        raise Unreadable("declares XML entities, which are not read; export it again")
