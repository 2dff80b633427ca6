"""Conventions of the command line: completions, man pages, schemas, exit codes, negative numbers, interruptions."""

import json
import os
import shutil
import signal
import subprocess
import time

import numpy as np
import pytest

import schemas
from actuator_fmu import DEFAULT_FMU
from hidden import product
from own_actuators import actuator, write_csv
from own_program import PROGRAM

pytestmark = product.needs_program()
SHELLS = ("bash", "zsh", "fish")


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    """Records with hidden play, a fit without it, and its diagnosis."""
    folder = tmp_path_factory.mktemp("demo")
    actuator("demo", "-o", folder, "--force")
    return folder


def run(*arguments, **options):
    return subprocess.run([str(PROGRAM), *map(str, arguments)], capture_output=True, text=True, **options)


def shell(name, script, folder):
    if shutil.which(name) is None:
        pytest.skip(f"no {name} here (Debian: apt install {name})")
    environment = {"PATH": f"{PROGRAM.parent}{os.pathsep}{os.environ['PATH']}", "HOME": str(folder)}
    return subprocess.run([name, "-c", script], cwd=folder, env=environment, capture_output=True, text=True)


@pytest.mark.parametrize("name", SHELLS)
def test_completions_load_and_know_commands_and_options(tmp_path, name):
    (tmp_path / "completions").write_text(actuator("completions", name))
    ask = {
        "bash": "set -e; source completions; complete -p actuator; COMP_WORDS=(actuator fi) COMP_CWORD=1; _actuator actuator fi actuator;"
        " echo ${COMPREPLY[@]}; COMP_WORDS=(actuator fit --ord) COMP_CWORD=2; _actuator actuator --ord fit; echo ${COMPREPLY[@]}",
        "zsh": "autoload -U compinit; compinit -D; source ./completions; whence -w _actuator; which _actuator__subcmd__fit_commands >/dev/null"
        " || which _actuator__fit_commands > /dev/null; grep -o 'fit:Identify' completions | head -1; grep -o -- '--order' completions | head -1",
        "fish": "source completions; complete -C 'actuator fi'; complete -C 'actuator fit --ord'",
    }[name]
    done = shell(name, ask, tmp_path)
    assert done.returncode == 0 and not done.stderr, done
    assert "fit" in done.stdout and "--order" in done.stdout, done.stdout


def test_man_pages_render(tmp_path):
    said = actuator("man", "-o", tmp_path / "man1")
    pages = sorted(path.name for path in (tmp_path / "man1").iterdir())
    assert {"actuator.1", "actuator-fit.1", "actuator-diagnose.1"} <= set(pages) and str(len(pages)) in said
    assert "actuator-render.1" not in pages  # not for users
    if shutil.which("man") is None:
        pytest.skip("no man here (Debian: apt install man-db)")
    for page in pages:
        command = ["man", "--warnings", "-E", "UTF-8", "-l", page]
        done = subprocess.run(command, cwd=tmp_path / "man1", env={**os.environ, "MANPAGER": "cat"}, capture_output=True, text=True)
        assert done.returncode == 0 and not done.stderr.strip(), (page, done.stderr)
        assert "NAME" in done.stdout and "OPTIONS" in done.stdout, page
    assert "--order" in actuator("man", "fit").replace("\\-", "-")


def test_every_command_with_json_has_a_schema_that_its_json_fits(tmp_path, demo):
    """One JSON of each here; those of all other tests that call the program are validated against their schemas as well."""
    (tmp_path / "manifest.toml").write_text(
        f'[[record]]\nfile = "{demo}/sweep.csv"\nsurface = "rudder"\nstage = "new"\nload_case = "unloaded"\n'
        f'[[record]]\nfile = "nowhere.csv"\nsurface = "rudder"\nstage = "worn"\nload_case = "unloaded"\n'
    )
    write_csv(tmp_path / "command.csv", time=np.arange(200) * 0.005, command=np.sin(np.arange(200) * 0.1))
    from_fmu = ["--from", DEFAULT_FMU]
    commands = [
        ["sets"],
        ["sets", "--ssv", tmp_path / "ssv"],
        ["effects"],
        ["build", *from_fmu, "-o", tmp_path / "a.fmu"],
        ["build", *from_fmu, "--ssp", tmp_path / "a.ssp"],
        ["excite", "steps", "-o", tmp_path / "steps.csv"],
        ["export", "te-early-loaded", "--to", "c", "-o", tmp_path / "te.c"],
        ["simulate", "te-early-loaded", tmp_path / "command.csv", "-o", tmp_path / "response.csv"],
        ["inspect", demo / "sweep.csv", demo / "random.csv"],
        ["frf", demo / "sweep.csv"],
        ["frf", demo / "sweep.csv", "--method", "report"],
        ["fit", demo / "sweep.csv", "--check", demo / "random.csv", "--order", "3", "--delay", "free"],
        ["fit", demo / "sweep.csv", "--method", "report"],
        ["compare", "us-early-unloaded", "us-late-unloaded"],
        ["compare"],
        ["generate-campaign", "-o", tmp_path / "campaign"],
        ["campaign", tmp_path / "manifest.toml", "-o", tmp_path / "results", "--no-diagnosis"],
    ]
    for command in commands:
        actuator(*command, "--json")
    diagnosis = json.loads((demo / "diagnosis" / "diagnosis.json").read_text())
    schemas.check("diagnose", diagnosis)
    assert {command[0] for command in commands} | {"diagnose"} == set(schemas.names())
    for name in schemas.names():
        schema = schemas.validator(name).schema
        assert schema["title"] and (name == "diagnose" or '"additionalProperties": false' in json.dumps(schema))
    with pytest.raises(AssertionError, match="verdict"):
        schemas.check("diagnose", diagnosis | {"verdict": "perhaps"})
    assert "diagnose" in actuator("schema", "diagnosis", succeeds=False)


def test_exit_codes_tell_the_verdict_when_asked(tmp_path, demo):
    records = ["--fit", demo / "sweep.csv", demo / "random.csv", "--check", demo / "multisine.csv", "--from", DEFAULT_FMU]
    named = run("diagnose", "--model", demo / "fitted.toml", *records, "-o", tmp_path / "one", "--exit-code")
    assert named.returncode == 10, named
    again = ["diagnose", "--model", tmp_path / "one" / "model.toml", *records, "-o", tmp_path / "two"]
    assert run(*again, "--exit-code").returncode == 0
    assert run("inspect", demo / "sweep.csv", "--exit-code").returncode == 0
    assert run("inspect", demo / "sweep.csv", demo / "sweep.csv", "--exit-code").returncode == 10
    noise = np.random.default_rng(3).normal(size=(2, 500))
    dead = write_csv(tmp_path / "dead.csv", time=np.arange(500) * 0.005, command=noise[0], position=noise[1])
    assert run("inspect", dead, "--exit-code").returncode == 11
    assert run("inspect", dead).returncode == 0
    for verdict in ("nothing missing", "named", "leading", "ambiguous", "unexplained"):
        assert verdict in actuator("diagnose", "--help")


def test_negative_numbers_are_values(tmp_path, demo):
    for arguments, words in (
        (["fit", demo / "sweep.csv", "--delay", "-0.01"], "from 0 on"),
        (["excite", "sweep", "--amplitude", "-2"], "amplitude"),
        (["excite", "sweep", "--band", "-1", "5"], "band"),
        (["excite", "sweep", "--quiet", "-1e-3", "--duration", "-5"], "duration"),
    ):
        message = actuator(*arguments, succeeds=False)
        assert words in message and "unexpected argument" not in message, message


COMPLETE = {"diagnosis.json", "report.html", "model.toml", "model.fmu"}


def test_a_diagnosis_is_the_same_to_the_byte_for_any_number_of_threads(tmp_path, demo):
    def files(threads):
        folder = tmp_path / "result"
        records = ["--fit", demo / "sweep.csv", demo / "random.csv", "--check", demo / "multisine.csv", "--from", DEFAULT_FMU]
        made = run(
            "diagnose", "--model", demo / "fitted.toml", *records, "-o", folder, env=os.environ | {"RAYON_NUM_THREADS": threads}
        )
        assert made.returncode == 0, made
        contents = {path.name: path.read_bytes() for path in folder.iterdir()}
        shutil.rmtree(folder)
        return contents

    alone = files("1")
    assert set(alone) == COMPLETE
    for threads in ("2", "5"):
        assert files(threads) == alone, threads


@pytest.mark.skipif(os.name == "nt", reason="signals")
@pytest.mark.parametrize("ending, instants", [(signal.SIGINT, 5), (signal.SIGTERM, 2)])
def test_an_interruption_leaves_nothing_half_written(tmp_path, demo, ending, instants):
    """At any time from the start of a diagnosis to its end: all of its files or none, and no temporary ones."""
    temporary, codes = tmp_path / "tmp", []
    temporary.mkdir()
    command = [str(PROGRAM), "diagnose", "--model", str(demo / "fitted.toml"), "--from", str(DEFAULT_FMU)]
    command += ["--fit", str(demo / "sweep.csv"), str(demo / "random.csv"), "--check", str(demo / "multisine.csv")]
    started = time.monotonic()
    subprocess.run([*command, "-o", str(tmp_path / "whole")], env=os.environ | {"TMPDIR": str(temporary)}, capture_output=True, check=True)
    whole_s = time.monotonic() - started
    for instant in range(instants):
        folder = tmp_path / f"{ending}-{instant}"
        process = subprocess.Popen(
            [*command, "-o", str(folder)], env=os.environ | {"TMPDIR": str(temporary)}, stdout=subprocess.PIPE, stderr=subprocess.PIPE
        )
        time.sleep(0.03 + whole_s * (instant + 0.5) / instants)
        process.send_signal(ending)
        process.communicate()
        codes.append(process.returncode)
        left = {path.name for path in folder.iterdir()} if folder.exists() else set()
        assert left in (set(), COMPLETE), left
        assert not list(temporary.iterdir()), (process.returncode, list(temporary.iterdir()))
    assert set(codes) <= {0, 130} and 130 in codes, codes


STEPS = ("explaining the records", "measuring the difference on the FMUs", "writing the report")


def left_times(lines):
    return [(one["elapsed_s"], one["left_s"]) for one in map(json.loads, lines) if one["left_s"] is not None]


def test_progress_is_said_where_it_is_asked_for_and_the_time_left_does_not_jump(tmp_path, demo):
    command = ["diagnose", "--model", demo / "fitted.toml", "--fit", demo / "sweep.csv", demo / "random.csv", "--from", DEFAULT_FMU]
    quiet = run(*command, "-o", tmp_path / "quiet")
    assert quiet.returncode == 0 and not quiet.stderr, quiet.stderr
    asked = run(*command, "-o", tmp_path / "asked", env=os.environ | {"ACTUATOR_PROGRESS": "lines"})
    lines = [line for line in asked.stderr.splitlines() if '"progress"' in line]
    assert asked.returncode == 0 and len(lines) == len(asked.stderr.splitlines()), asked.stderr
    if not lines:
        pytest.skip("over within a second")
    assert any(step in lines[0] for step in STEPS), lines[0]
    known = left_times(lines)
    for (before_s, before), (now_s, now) in zip(known, known[1:]):
        assert now >= 0 and before - now < 0.5 * before + 2 * (now_s - before_s) + 0.5, known
    for name in ("diagnosis.json", "model.toml"):
        assert len((tmp_path / "asked" / name).read_bytes()) == pytest.approx(len((tmp_path / "quiet" / name).read_bytes()), abs=4)


@pytest.mark.skipif(os.name == "nt", reason="terminals")
def test_a_terminal_shows_the_time_left_and_an_interruption_leaves_it_clean(tmp_path, demo):
    import pty

    command = ["diagnose", "--model", demo / "fitted.toml", "--fit", demo / "sweep.csv", "--from", DEFAULT_FMU, "-o", tmp_path / "out"]
    shown, terminal = pty.openpty()
    process = subprocess.Popen([str(PROGRAM), *map(str, command)], stdout=subprocess.DEVNULL, stderr=terminal)
    os.close(terminal)
    said = b""
    try:
        while b" left" not in said:
            said += os.read(shown, 4096)
        process.send_signal(signal.SIGINT)
        while True:
            said += os.read(shown, 4096)
    except OSError:  # the terminal no longer has a writer
        pass
    finally:
        process.wait()
        os.close(shown)
    if process.returncode == 0:
        pytest.skip("over within a second")
    assert process.returncode == 130 and any(step.encode() in said for step in STEPS), said
    last = said.rsplit(b"\r", 2)
    assert b"interrupted" in b"".join(last[-2:]) and b" left" not in said.split(b"actuator: interrupted")[1], said
    assert not (tmp_path / "out").exists()


LINEAR_EFFECTS = {
    "delay": ("time = { value = 0.01, unit = 's' }", lambda s: np.exp(-0.01 * s)),
    "sensor_lag": ("time = { value = 0.02, unit = 's' }", lambda s: 1.0 / (1.0 + 0.02 * s)),
    "structural_mode": (
        "frequency = { value = 9.0, unit = 'Hz' }\ndamping = { value = 0.03, unit = '1' }\ngain = { value = 0.1, unit = '1' }",
        lambda s: 0.9 + 0.1 / ((s / (18.0 * np.pi)) ** 2 + 0.06 * s / (18.0 * np.pi) + 1.0),
    ),
    "hinge_load": (
        "stiffness = { value = 0.2, unit = '1' }",
        lambda s: ((s / 60.0) ** 2 + 1.4 * s / 60.0 + 1.0) / ((s / 60.0) ** 2 + 1.4 * s / 60.0 + 1.2),
    ),
}


def model_text(effects=""):
    numbers = {"k": (1.0, "deg/deg"), "p": (200.0, "1/s"), "omega": (60.0, "rad/s"), "zeta": (0.7, "1")}
    base = "".join(f"{name} = {{ value = {value}, unit = '{unit}' }}\n" for name, (value, unit) in numbers.items())
    return f"[model]\nname = 'servo'\n[base]\norder = 3\n{base}{effects}"


@pytest.mark.parametrize("effect", LINEAR_EFFECTS)
def test_models_are_compared_with_their_linear_effects(tmp_path, effect):
    numbers, ratio = LINEAR_EFFECTS[effect]
    (tmp_path / "one.toml").write_text(model_text())
    (tmp_path / "other.toml").write_text(model_text(f"[effects.{effect}]\n{numbers}\n"))
    found = json.loads(actuator("compare", tmp_path / "one.toml", tmp_path / "other.toml", "--json"))["against_first"][0]["data_band"]
    s = 2j * np.pi * np.arange(50, 1201) / 100.0
    base = 1.0 / ((1.0 + s / 200.0) * ((s / 60.0) ** 2 + 1.4 * s / 60.0 + 1.0))
    assert found["magnitude"]["max"] == pytest.approx(np.abs(np.abs(base * ratio(s)) - np.abs(base)).max(), rel=1e-9)
    assert found["phase_deg"]["max"] == pytest.approx(np.abs(np.degrees(np.angle(ratio(s)))).max(), rel=1e-9)


def test_an_effect_that_is_not_linear_is_left_out_of_a_comparison_and_said(tmp_path):
    (tmp_path / "one.toml").write_text(model_text())
    (tmp_path / "other.toml").write_text(model_text("[effects.backlash]\ngap = { value = 0.3, unit = 'deg' }\n[effects.sensor_bias]\noffset = { value = 0.1, unit = 'deg' }\n"))
    models = [tmp_path / "one.toml", tmp_path / "other.toml"]
    assert f"{models[1]}: without backlash" in actuator("compare", *models)
    one, other = json.loads(actuator("compare", *models, "--json"))["sets"]
    assert "left_out" not in one and other["left_out"] == ["backlash"]
    schemas.check("compare", json.loads(actuator("compare", *models, "--json")))


def test_what_would_be_ignored_is_refused(tmp_path):
    refused = run("build", "--set", "us-late-loaded", "-o", tmp_path / "set.fmu")
    assert refused.returncode == 2 and "--set" in refused.stderr and not (tmp_path / "set.fmu").exists()
    folder = run("build", "--model", "us-late-loaded", "-o", tmp_path, "--force")
    assert folder.returncode == 2 and "a folder" in folder.stderr and "--force" not in folder.stderr


def test_the_band_of_a_command_is_said_where_it_has_one():
    assert ", 2 to 5 Hz," in run("excite", "sweep", "--band", "2", "5").stderr
    assert " Hz" not in run("excite", "steps", "--band", "2", "5").stderr


def test_a_record_too_short_to_be_divided_is_refused_with_what_to_do(tmp_path):
    time = np.arange(150) / 100.0
    command = np.sin(2.0 * np.pi * 2.0 * time)
    write_csv(tmp_path / "short.csv", time=time, command=command, position=np.sin(2.0 * np.pi * 2.0 * (time - 0.02)))
    refused = run("diagnose", "--model", "us-late-loaded", "--fit", tmp_path / "short.csv", "-o", tmp_path / "out")
    assert refused.returncode == 2 and "of 150 samples 30 % are held out" in refused.stderr and "--check" in refused.stderr, refused.stderr
