"""The package for OptunaHub has what its registry asks for, and leads to the sampler."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import yaml

from hotlap import tuners
from hotlap.optuna import HotlapSampler

PACKAGE = Path(__file__).parents[2] / "optunahub" / "package" / "samplers" / "hotlap"


def test_the_package_is_laid_out_as_the_registry_wants():
    assert {path.name for path in PACKAGE.iterdir() if path.is_file()} == {"README.md", "LICENSE", "__init__.py", "example.py"}
    assert (PACKAGE / "LICENSE").read_text().startswith("MIT License")


def test_the_front_matter_is_complete():
    _, front, text = (PACKAGE / "README.md").read_text(encoding="utf-8").split("---\n", 2)
    matter = yaml.safe_load(front)
    assert set(matter) == {"author", "title", "description", "tags", "optuna_versions", "license"}
    assert matter["license"] == "MIT License"
    assert "sampler" in matter["tags"]
    assert "`HotlapSampler(" in text
    assert all(f"`{name}`" in text for name in {name.partition(":")[0] for name in tuners.names()})


def test_it_leads_to_the_sampler():
    specification = importlib.util.spec_from_file_location("hotlap_package", PACKAGE / "__init__.py")
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    assert module.HotlapSampler is HotlapSampler
