"""One page of each kind, made by the program beside the records of its demo: what a page begins with, and where its links lead."""

from own_actuators import actuator

PAGES = ["inspection/inspection.html", "fit/fit.html", "diagnosis/report.html", "comparison/compare.html", "campaign/report.html"]

# Two records of one worn actuator, and one that is not there.
MANIFEST = """[campaign]
name = "Rudder's wear"
""" + "".join(
    f'[[record]]\nfile = "{name}.csv"\nsurface = "rudder"\nstage = "{stage}"\nload_case = "unloaded"\n'
    for name, stage in (("sweep", "worn"), ("random", "worn"), ("nowhere", "lost"))
)


def made_pages(folder):
    """The folder of a demo, with a page of each command in it."""
    actuator("inspect", folder / "sweep.csv", folder / "multisine.csv", "-o", folder / "inspection")
    fit = ["fit", folder / "sweep.csv", folder / "random.csv", "--check", folder / "multisine.csv", "--order", "2"]
    actuator(*fit, "-o", folder / "fit" / "rudder's.toml", "--report", folder / "fit" / "fit.html")
    actuator("compare", "te-early-unloaded", folder / "fitted.toml", "-o", folder / "comparison")
    (folder / "manifest.toml").write_text(MANIFEST)
    actuator("campaign", folder / "manifest.toml", "-o", folder / "campaign")
    return folder
