"""The page on clusters: scripts parse, Dask options exist, shards make a whole, the example runs."""

import os
import re
import runpy
import subprocess

import pytest
from chunked_work import SCENE

from pounding_risk.ensemble.identity import flattened
from pounding_risk.ensemble.threads import read_shard
from pounding_risk.errors import PoundingError
from pounding_risk.results.files import open_results


@pytest.fixture(scope="module")
def page(root):
    return (root / "docs" / "cluster.md").read_text(encoding="utf-8")


def blocks(page, language):
    return re.findall(rf"^```{language}\n(.*?)^```", page, re.S | re.M)


def slurm(page):
    (script,) = (block for block in blocks(page, "sh") if block.startswith("#!/bin/sh\n#SBATCH"))
    return script


def words_after(program, page):
    """The arguments of every call of a program in the scripts and sentences of the page."""
    text = "\n".join([*blocks(page, "sh"), *re.findall(r"`([^`\n]+)`", page)])
    calls = re.findall(rf"(?:^|[\s\"']){program} ([a-z][^|&\n]*)", text, re.M)
    return [call.replace('"', " ").replace("'", " ").split() for call in calls]


def test_scripts_parse(page):
    scripts = blocks(page, "sh")
    assert len(scripts) >= 6
    for script in scripts:
        run = subprocess.run(["bash", "-n"], input=script, capture_output=True, text=True)
        assert (run.returncode, run.stderr) == (0, ""), script


def test_dask_commands_and_options_are_real(page):
    pytest.importorskip("distributed")
    from distributed.cli import dask_scheduler, dask_worker

    programs = {"scheduler": dask_scheduler.main, "worker": dask_worker.main}
    calls = words_after("dask", page)
    assert {name for name, *_ in calls} == set(programs)
    for name, *rest in calls:
        known = {flag for option in programs[name].params for flag in option.opts}
        assert {word for word in rest if word.startswith("-")} <= known, (name, rest)


def test_each_task_of_the_array_takes_its_shard(page, tmp_path):
    """The script as a batch system starts it, with a program that prints its arguments."""
    first, last = map(int, re.search(r"--array=(\d+)-(\d+)", page).groups())
    program = tmp_path / "pounding-risk"
    program.write_text('#!/bin/sh\npwd\necho "$@"\n')
    program.chmod(0o755)
    shards = []
    for task in (first, 7, last):
        environment = {
            **os.environ,
            "PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}",
            "SLURM_SUBMIT_DIR": str(tmp_path),
            "SLURM_CPUS_PER_TASK": "4",
            "SLURM_ARRAY_TASK_ID": str(task),
        }
        run = subprocess.run(["sh"], input=slurm(page), env=environment, capture_output=True, text=True, check=True)
        folder, words = run.stdout.splitlines()
        assert os.path.samefile(folder, tmp_path)
        assert words.startswith("scan scene.toml -o results.nc --workers 4 --shard ")
        shards.append(read_shard(words.split()[-1]))
    assert shards == [(1, last), (7, last), (last, last)]


@pytest.mark.complete
def test_the_example_runs(page, monkeypatch, tmp_path):
    pytest.importorskip("distributed")
    (example,) = blocks(page, "python")
    (tmp_path / "scene.toml").write_text(SCENE, encoding="utf-8")
    (tmp_path / "example.py").write_text(example, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    namespace = runpy.run_path(str(tmp_path / "example.py"), run_name="__main__")
    assert namespace["dataset"].identical(open_results("results.nc"))


def test_the_configuration_of_tls_is_one_that_dask_reads(page):
    """With the page's configuration Dask requires encryption, with a key for each part, and refuses a plain address."""
    dask = pytest.importorskip("dask")
    distributed = pytest.importorskip("distributed")
    yaml = pytest.importorskip("yaml")
    from pounding_risk.ensemble.dask import Dask

    (text,) = blocks(page, "yaml")
    with dask.config.set(flattened(yaml.safe_load(text))):
        security = distributed.Security()
        assert security.require_encryption and security.tls_ca_file == "/home/user/cluster/ca.pem"
        for part in ("scheduler", "worker", "client"):
            assert security.get_tls_config_for_role(part)["key"] == "/home/user/cluster/node-key.pem"
        with pytest.raises(PoundingError, match=r'"tcp://127.0.0.1:1" is not encrypted, .*; write tls://'):
            Dask("tcp://127.0.0.1:1")
