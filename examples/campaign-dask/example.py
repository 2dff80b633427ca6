"""Records with known truth, made by `actuator`: four wears of one actuator, and the manifest of their diagnoses."""

import subprocess

from diagnosis_jobs import Job, write_noisy_records
from manifest import Mistake

SET = "te-early-unloaded"
NOISE_RMS_DEG = 0.02  # some 2 % of the motion
AMPLITUDE_DEG = 2
QUIET_S = 0.5  # rest at both ends
COMMANDS = {"sweep": "fit", "random": "fit", "multisine": "check"}  # kinds of `actuator excite`, and the use of their records
WEAR = {
    "new": "",
    "worn": "[effects.backlash]\ngap = { value = 0.15, unit = \"deg\" }\n",
    "stiff": "[effects.coulomb_friction]\nlevel = { value = 0.15, unit = \"deg\" }\n",
    "slow": "[effects.rate_limit]\nup = { value = 50.0, unit = \"deg/s\" }\ndown = { value = 50.0, unit = \"deg/s\" }\n",
}
BASE = """[base]
order = 3
k = { value = 1.0198, unit = "deg/deg" }
p = { value = 10000.0, unit = "1/s" }
omega = { value = 165.26, unit = "rad/s" }
zeta = { value = 0.5624, unit = "1" }

"""  # te-early-unloaded, NASA/TM-1998-208452, table 1


def write(options):
    """worn.toml and its like (the truth), worn-sweep.csv and its like (records with noise), manifest.toml."""
    folder = options.output
    if (folder / "manifest.toml").exists():
        raise Mistake(f"{folder / 'manifest.toml'}: exists; allowed: a new or empty folder")
    commands = excite(options.program, folder, options.duration)
    for seed, (wear, effects) in enumerate(WEAR.items(), 1):
        (folder / f"{wear}.toml").write_text(BASE + effects)
        clean = simulate(options.program, folder, f"{wear}.toml", commands, folder / "clean" / wear)
        names = tuple(path.name for path in clean)
        noisy = Job(name=wear, base=str(folder / "clean" / wear), folder="", program="", model="", fit=names,
                    noise_rms_deg=NOISE_RMS_DEG, seed=seed)  # fmt: skip
        (folder / "records" / wear).mkdir(parents=True, exist_ok=True)
        write_noisy_records(noisy, folder / "records" / wear)
    (folder / "manifest.toml").write_text("\n".join(map(entry, WEAR)))
    print(f"{len(WEAR)} jobs, {len(WEAR) * len(COMMANDS)} records; {folder / 'manifest.toml'}")
    return 0


def excite(program, folder, duration_s):
    """The commands, as CSV files."""
    paths = []
    for kind in COMMANDS:
        path = folder / f"{kind}-command.csv"
        call(program, "excite", kind, "--duration", duration_s, "--amplitude", AMPLITUDE_DEG, "--quiet", QUIET_S, "-o", path, "--force")
        paths.append(path)
    return paths


def simulate(program, folder, model, commands, clean):
    """Records of a model without noise, in the folder `clean`: sweep.csv, random.csv, multisine.csv."""
    clean.mkdir(parents=True, exist_ok=True)
    records = [clean / path.name.replace("-command", "") for path in commands]
    for command, record in zip(commands, records):
        call(program, "simulate", folder / model, command, "-o", record, "--force")
    return records


def call(program, *arguments):
    subprocess.run([program, *map(str, arguments)], check=True, capture_output=True, text=True)


def entry(wear):
    files = {use: [f"records/{wear}/{kind}.csv" for kind, wanted in COMMANDS.items() if wanted == use] for use in ("fit", "check")}
    return f'[[job]]\nname = "{wear}"\nmodel = "{SET}"\nfit = {quoted(files["fit"])}\ncheck = {quoted(files["check"])}\n'


def quoted(names):
    return "[" + ", ".join(f'"{name}"' for name in names) + "]"
