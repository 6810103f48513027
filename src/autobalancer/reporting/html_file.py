"""A report as one HTML file that needs nothing else: pictures and style are in it."""

from __future__ import annotations

import base64

from autobalancer.errors import QuestionError
from autobalancer.reporting.page import Block, Drawing, Listing, Paragraph, Report, Rows

PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{{ report.title }}</title>
<style>
body { font: 15px/1.5 system-ui, "Helvetica Neue", Arial, sans-serif; color: #222; max-width: 60rem;
  margin: 2rem auto; padding: 0 1.2rem; }
h1 { font-size: 1.7rem; margin-bottom: .3rem; }
  h2 { font-size: 1.2rem; margin-top: 2.2rem; border-bottom: 2px solid #e3e3e3; }
table { border-collapse: collapse; margin: .8rem 0; font-size: .92rem; }
  th { text-align: left; border-bottom: 1.5px solid #606060; }
td, th { padding: .2rem .8rem .2rem 0; vertical-align: top; white-space: pre-line; } tr + tr td { border-top: 1px solid #ececec; }
td.number, th.number { text-align: right; font-variant-numeric: tabular-nums; }
  table.facts td:first-child { white-space: nowrap; }
td.wide { white-space: normal; }
figure { margin: 1rem 0; } img { max-width: 100%; height: auto; } figcaption { font-size: .88rem; color: #505050; }
pre { background: #f5f6f7; padding: .7rem .9rem; white-space: pre-wrap; overflow-wrap: anywhere; font-size: .82rem; }
  .replay { font-size: .85rem; color: #505050; }
.strong { font-weight: 600; } .sign { display: flex; gap: 2rem; margin-top: 3rem; }
  .sign div { flex: 1; border-top: 1px solid #222; }
nav { font-size: .92rem; columns: 2; } a { color: #0072B2; }
@media (prefers-color-scheme: dark) { body { background: #1b1d1f; color: #e4e4e4; } pre { background: #26292c; }
  img { background: white; } tr + tr td { border-color: #333; } h2 { border-color: #444; }
  .replay, figcaption { color: #aaa; } a { color: #56B4E9; } }
@media print { body { max-width: none; margin: 0; } h2 { break-after: avoid; } figure, tr { break-inside: avoid; }
  nav { display: none; } section:nth-of-type(2) { break-before: page; } }
</style>
</head>
<body>
<h1>{{ report.title }}</h1>
{{ block(about) }}
{% for section in report.sections %}
<section aria-labelledby="s{{ loop.index }}">
<h2 id="s{{ loop.index }}">{{ loop.index }} {{ section.title }}</h2>
{% for one in section.blocks %}{{ block(one) }}
{% endfor %}{% if section.replay %}<div class="replay">made by<pre>{{ section.replay }}</pre></div>{% endif %}
</section>
{% if loop.first %}{% if report.sign %}
<div class="sign"><div>name</div><div>date</div><div>signature</div></div>{% endif %}
<nav aria-label="contents">{% for section in report.sections %}
<div><a href="#s{{ loop.index }}">{{ loop.index }} {{ section.title }}</a></div>{% endfor %}
</nav>{% endif %}
{% endfor %}
</body>
</html>
"""
TABLE = """<table{% if not rows.head %} class="facts"{% endif %}>{% if rows.head %}<thead><tr>{% for cell in rows.head %}
<th{% if numeric[loop.index0] %} class="number"{% endif %}>{{ cell }}</th>{% endfor %}</tr></thead>{% endif %}<tbody>
{% for row in rows.rows %}<tr>{% for cell in row %}
<td{% if numeric[loop.index0] %} class="number"{% endif %}>{{ cell }}</td>{% endfor %}</tr>
{% endfor %}</tbody></table>"""


def html_text(report: Report) -> str:
    """The whole file.

    Raises
    ------
    QuestionError
        If Jinja2 is not installed.
    """
    try:
        from jinja2 import Environment
        from markupsafe import Markup, escape
    except ImportError:
        raise QuestionError(
            "report: Jinja2 is not installed; install it with: pip install 'autobalancer[report]'"
        ) from None
    environment = Environment(autoescape=True)
    page, table = environment.from_string(PAGE), environment.from_string(TABLE)

    def block(one: Block) -> Markup:
        if isinstance(one, Paragraph):
            return Markup('<p class="strong">{}</p>' if one.strong else "<p>{}</p>").format(one.text)
        if isinstance(one, Rows):
            numeric = one.numeric or (False,) * 99
            return Markup(table.render(rows=one, numeric=numeric))
        if isinstance(one, Drawing):
            data = base64.b64encode(one.png).decode()
            words = escape(one.caption)
            return Markup(
                f'<figure><img alt="{words}" src="data:image/png;base64,{data}"><figcaption>{words}</figcaption></figure>'
            )
        assert isinstance(one, Listing)
        return Markup("<pre>{}</pre>").format(one.text)

    return page.render(report=report, about=Rows((), report.about), block=block)
