"""Every study that a page of the report names is there, with its template."""

from importlib import import_module

import pytest

from analysis.__main__ import PAGES
from analysis.writing import _TEMPLATES

STUDIES = {name: f"{page.package}.{name}" for page in PAGES.values() for name in page.studies}


@pytest.mark.parametrize("name", STUDIES)
def test_a_study_can_be_run(name):
    assert callable(import_module(STUDIES[name]).run)


@pytest.mark.parametrize("name", _TEMPLATES.list_templates())
def test_a_template_can_be_read(name):
    assert _TEMPLATES.get_template(name)


@pytest.mark.parametrize("page", [page.name for page in PAGES.values()])
def test_a_page_has_a_template(page):
    assert _TEMPLATES.get_template(f"pages/{page}.md")
