"""Compiles an exported C file and steps it: exported.c, name, command.csv, step [s], positions.txt."""

import pathlib
import subprocess
import sys

exported, name, commands, _, positions = sys.argv[1:]
folder = pathlib.Path(exported).parent
rows = [tuple(map(float, row.split(",")[:2])) for row in pathlib.Path(commands).read_text().splitlines()[1:]]
main = f"""
#include <stdio.h>
#include "{pathlib.Path(exported).name}"
int main(void) {{
    static {name}_state state;
    double time, next, command, following;
    {name}_reset(&state, 0.0);
    printf("%.17g\\n", measured(&state, 0.0));
    if (scanf("%lf %lf", &time, &command) != 2) return 1;
    while (scanf("%lf %lf", &next, &following) == 2) {{
        printf("%.17g\\n", {name}_step(&state, command, next - time));
        time = next, command = following;
    }}
    return 0;
}}
"""
(folder / "main.c").write_text(main)
program = folder / "program"
subprocess.run(["cc", "-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-o", program, folder / "main.c", "-lm"], check=True)
given = "".join(f"{time!r} {command!r}\n" for time, command in rows)
pathlib.Path(positions).write_text(subprocess.run([program], input=given, capture_output=True, text=True, check=True).stdout)
version = subprocess.run(["cc", "--version"], capture_output=True, text=True, check=True).stdout.splitlines()[0]
print(f"C compiled by {version}")
