"""A report as a typeset PDF (typst)."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path

from autobalancer.errors import QuestionError
from autobalancer.reporting.page import Block, Drawing, Listing, Paragraph, Report, Rows
from autobalancer.safe_file import write_safely

HEAD = """#set page(paper: "a4", margin: (x: 2.2cm, top: 2.2cm, bottom: 2cm), numbering: "1 / 1")
#set text(size: 9.5pt, lang: "en")
#set par(justify: false)
#set heading(numbering: "1")
#show heading.where(level: 1): set text(size: 13pt)
#show heading.where(level: 1): set block(above: 1.6em, below: 0.8em)
#show raw.where(block: true): it => block(fill: luma(245), inset: 6pt, width: 100%, text(size: 7.5pt, it))
#show figure.caption: set text(size: 8pt, fill: luma(80))
#set table(stroke: (x, y) => if y == 0 { none } else { (top: 0.4pt + luma(210)) }, inset: (x: 4pt, y: 3pt))
"""


def write_pdf(report: Report, path: Path) -> None:
    """Write the file.

    Raises
    ------
    QuestionError
        If typst is not installed.
    ResultError
        If the file cannot be written.
    """
    try:
        import typst
    except ImportError:
        raise QuestionError(
            "report: typst, which sets PDF files, is not installed; install it with: pip install 'autobalancer[report]', "
            "or write .html"
        ) from None
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "report.typ"
        source.write_text(_source(report, Path(folder)), encoding="utf-8")
        made = typst.compile(str(source))
        write_safely(path, lambda file: file.write_bytes(made))


def _source(report: Report, folder: Path) -> str:
    parts = [HEAD, f"#set document(title: {_text(report.title)})"]
    parts.append(f'#text(size: 18pt, weight: "bold")[#{_text(report.title)}]')
    parts.append(_block(Rows((), report.about), folder, 0, 0))
    for number, section in enumerate(report.sections):
        parts.append(f"#heading(level: 1)[#{_text(section.title)}]")
        parts += [_block(one, folder, number, place) for place, one in enumerate(section.blocks)]
        if section.replay:
            parts.append(f"#text(size: 8pt, fill: luma(80))[made by] #raw({_text(section.replay)}, block: true)")
        if not number and report.sign:  # the first page is the one that is signed
            parts.append(
                "#v(2.2cm) #grid(columns: (1fr, 1fr, 1fr), gutter: 1cm, "
                + ", ".join(
                    f"[#line(length: 100%, stroke: 0.5pt) #text(size: 8pt)[{one}]]"
                    for one in ("name", "date", "signature")
                )
                + ")"
            )
            parts.append("#pagebreak(weak: true)")
    return "\n\n".join(parts)


def _text(text: str) -> str:
    """A text as a string of typst, so that nothing in it is read as a command."""
    return json.dumps(text, ensure_ascii=False).replace("\\/", "/")


def _block(one: Block, folder: Path, section: int, place: int) -> str:
    if isinstance(one, Paragraph):
        return f'#text(weight: "{"bold" if one.strong else "regular"}")[#{_text(one.text)}]'
    if isinstance(one, Listing):
        return f"#raw({_text(one.text)}, block: true)"
    if isinstance(one, Drawing):
        name = f"picture-{section}-{place}.png"
        (folder / name).write_bytes(one.png)
        words = _text(one.caption)
        return f'#figure(image("{name}", width: 92%, alt: {words}), caption: [#{words}], numbering: none)'
    return _table(one)


def _table(rows: Rows) -> str:
    width = len(rows.rows[0]) if rows.rows else len(rows.head)
    numeric = rows.numeric or (False,) * width
    align = ", ".join("right" if one else "left" for one in numeric)
    wide = rows.wide if any(rows.wide) else (False, width == 2 and not rows.head) + (False,) * (width - 2)
    sizes = ", ".join("1fr" if one else "auto" for one in wide[:width])
    heads = [
        cell if one or not any(rows.wide) else cell.replace(" ", "\n")
        for cell, one in zip(rows.head, wide, strict=False)
    ]
    cells = [f"[*#{_text(cell)}*]" for cell in heads]
    cells += [f"[#{_text(cell)}]" for row in rows.rows for cell in row]
    return f"#table(columns: ({sizes},), align: ({align},), {', '.join(cells)})"
