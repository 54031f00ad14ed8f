"""Templates of the report: strict, and their tables are files, too."""

import jinja2
import pytest

from analysis import writing

TEMPLATE = """\
{% call table("sizes") %}
| size, m | count |
| --- | --- |
{% for size, count in rows %}
| {{ size | f(".2f") }} | {{ count }} |
{% endfor %}
{% endcall %}
"""


@pytest.fixture
def template(monkeypatch):
    templates = writing._TEMPLATES.overlay(loader=jinja2.DictLoader({"sizes.md": TEMPLATE}))
    monkeypatch.setattr(writing, "_TEMPLATES", templates)


def test_a_table_of_a_template_becomes_a_file(template, tmp_path):
    page = writing.Report(tmp_path).render("sizes", {}, rows=[(1.0, 3), (0.125, "")])
    assert page == "| size, m | count |\n| --- | --- |\n| 1.00 | 3 |\n| 0.12 |  |\n"
    written = (tmp_path / "tables" / "sizes.csv").read_text(encoding="utf-8")
    assert written == '"size, m",count\n1.00,3\n0.12,\n'


def test_a_value_that_a_template_lacks_is_an_error(template, tmp_path):
    with pytest.raises(jinja2.UndefinedError, match="rows"):
        writing.Report(tmp_path).render("sizes", {})
