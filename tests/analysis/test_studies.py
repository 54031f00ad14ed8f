"""Every study that a page of the report names is there, with its template."""

from importlib import import_module

from analysis.__main__ import PAGES
from analysis.writing import _TEMPLATES


def test_studies_can_be_run():
    for page in PAGES.values():
        for name in page.studies:
            assert callable(import_module(f"{page.package}.{name}").run), name


def test_templates_can_be_read():
    names = _TEMPLATES.list_templates()
    assert {f"pages/{page.name}.md" for page in PAGES.values()} <= {*names}
    for name in names:
        assert _TEMPLATES.get_template(name)
