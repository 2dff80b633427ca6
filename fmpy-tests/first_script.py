import fmpy, matplotlib.pyplot as plt, numpy as np
from scipy.signal import step

k, omega, zeta = 1.0767, 100.72, 0.4615  # upper spoiler, late, loaded (NASA/TM-1998-208452, table 2)
start = {"surface": 2, "stage": 3, "load_case": 2, "command": 1.0}  # upper_spoiler, late, loaded; 1 deg
fmu = fmpy.simulate_fmu("target/fmu/BactActuator.fmu", start_values=start, stop_time=0.15, output_interval=0.005, output=["position"])
time, analytic = step(([k * omega**2], [1, 2 * zeta * omega, omega**2]), T=np.linspace(0, 0.15, 301))
plt.plot(time, analytic, "-", fmu["time"], fmu["position"], "o")
plt.xlabel("time, s"), plt.ylabel("position, deg"), plt.legend(["analytic, equation (6)", "FMU, stepped every 5 ms"])
plt.savefig("us-late-loaded.png")
