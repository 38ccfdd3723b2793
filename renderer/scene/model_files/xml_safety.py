"""XML from files of unknown origin: no entities, so that none grows without end or names another file."""

from renderer.scene.model_files.record import Unreadable


def refuse_entities(data: bytes) -> None:
    """Raise Unreadable where an XML document declares entities or a document type."""
    head = data.replace(b"\x00", b"").upper()  # of UTF-16 too
    if b"<!ENTITY" in head or b"<!DOCTYPE" in head:
        raise Unreadable("declares XML entities, which are not read; export it again")
