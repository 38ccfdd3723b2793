"""Text of a file that does not state its character set, as files of instruments and manufacturers.

Numbers and keywords are ASCII in all of these, so only labels depend on the choice.
"""

import codecs
import re


def decode(data: bytes) -> str:
    """The text of a file.

    The character set is, in this order: the one of the byte-order mark; UTF-16 where every other byte is
    zero; UTF-8; Shift-JIS, Windows-1251 or GB 18030 where the letters come in the runs usual there;
    Windows-1252. Raises ValueError for data that are no text; the message completes a sentence that begins
    with the file's name.
    """
    if data[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE):
        return _utf_16(data, "utf-16")
    if b"\0" in data and not _padded(data):
        even, odd = data[:4000:2].count(0), data[1:4000:2].count(0)
        if max(even, odd) < 0.2 * len(data[:4000]) or min(even, odd) > 0:
            raise ValueError("is no plain text (it holds zero bytes). Save it as text, in UTF-8")
        return _utf_16(data, "utf-16-le" if odd > even else "utf-16-be")
    data = data.replace(b"\0", b" ")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return _legacy(data)


def _padded(data: bytes) -> bool:
    """Whether zero bytes only fill up fields of fixed length, for example behind a name."""
    rest = data.replace(b"\0", b"")
    runs = len(re.findall(rb"\0+", data))
    return not re.search(rb"[\x01-\x08\x0e-\x1f\x7f]", rest) and 2 * runs < data.count(b"\0") < len(rest)


def _utf_16(data: bytes, name: str) -> str:
    try:
        return data.decode(name)
    except UnicodeDecodeError:
        raise ValueError("is no plain text (its UTF-16 is cut short). Save it as text, in UTF-8") from None


def _legacy(data: bytes) -> str:
    """Text in the first of the older character sets that fits the bytes above ASCII."""
    if _all_wide(data, "cp932"):
        return data.decode("cp932")
    runs = re.findall(rb"[\x80-\xff]+", data)
    # Russian letters; no Western European word has three bytes above ASCII in a row.
    if (all(re.fullmatch(rb"[\xa8\xb8\xb9\xc0-\xff]+", run) for run in runs)
            and sum(len(run) >= 3 for run in runs) > len(runs) / 2):
        return data.decode("cp1251")
    if all(len(run) % 2 == 0 for run in runs) and _all_wide(data, "gb18030"):
        return data.decode("gb18030")
    try:
        return data.decode("cp1252")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def _all_wide(data: bytes, name: str) -> bool:
    """Whether, in that character set, all characters beyond ASCII are wide letters and at least two stand in
    a row. A single one may be an accented Latin letter that pairs with the next byte by chance."""
    try:
        text = data.decode(name)
    except UnicodeDecodeError:
        return False
    beyond = re.findall(r"[^\x00-\x7f]+", text)
    # Kana, ideographs and their signs; not narrow kana, because every Latin-1 text could be read as those.
    wide = re.compile("[\u3000-\u30ff\u3400-\u9fff\uff00-\uff60\uff64\uffe0-\uffef]")
    return all(wide.fullmatch(c) for run in beyond for c in run) and any(len(run) > 1 for run in beyond)
