"""Workflows of continuous integration and of releases: what they name exists; syntax is checked by actionlint."""

import os
import re
import subprocess
import tomllib
from pathlib import Path

import pytest

yaml = pytest.importorskip("yaml", reason="PyYAML is not installed")

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
WORKFLOWS = {path.name: yaml.safe_load(path.read_text()) for path in (ROOT / ".github" / "workflows").glob("*.yml")}
JOBS = {f"{file}: {name}": job for file, text in WORKFLOWS.items() for name, job in text["jobs"].items()}


def commands(job):
    """Lines of the shell of a job's steps."""
    return [line for step in job["steps"] for line in step.get("run", "").splitlines()]


def test_there_are_the_workflows_of_checks_and_of_releases():
    assert set(WORKFLOWS) == {"ci.yml", "release.yml"}


@pytest.mark.parametrize("job", JOBS.values(), ids=JOBS)
def test_what_a_job_names_exists(job):
    versions = {text.split()[-1] for text in PROJECT["classifiers"] if "Python :: 3." in text}
    for step in job["steps"]:
        assert str(step.get("with", {}).get("python-version", "3.11")) in versions
    for line in commands(job):
        for script in re.findall(r"(?<!\S)\.ci/\w+", line):
            assert os.access(ROOT / script, os.X_OK), script
        for extras in re.findall(r'"\.\[(.*?)\]"', line):
            assert set(extras.split(",")) <= set(PROJECT["optional-dependencies"])
        for module in re.findall(r"python -m (linkages\S*)", line):
            assert (ROOT / f"{module.replace('.', '/')}.py").is_file()


@pytest.mark.parametrize("file", WORKFLOWS)
def test_jobs_wait_for_jobs_that_there_are(file):
    jobs = WORKFLOWS[file]["jobs"]
    for job in jobs.values():
        needs = job.get("needs", [])
        assert set([needs] if isinstance(needs, str) else needs) <= set(jobs)


def test_a_release_has_kernels_in_its_wheel():
    build = WORKFLOWS["release.yml"]["jobs"]["build"]
    assert build["env"] == {"LINKAGES_PACK_KERNELS": "1"}
    assert any(".ci/release" in line for line in commands(build))


@pytest.mark.processes
def test_a_release_of_another_version_than_its_tag_ends_before_it_builds():
    done = subprocess.run([ROOT / ".ci" / "release", "v99.0"], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert done.stdout.splitlines()[-1] == f"tag v99.0, but pyproject.toml has version {PROJECT['version']}"
