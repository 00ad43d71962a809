"""Record the runs of the benchmark page, with the machine they ran on: ``python docs/recorded/record.py``."""

import json
import os
import platform
from pathlib import Path
from tempfile import TemporaryDirectory

from cutgap.views.cli import main

COMMAND = "gaps small --methods auto,task-balancing,k-means,local-search --seeds 3 --out"
HERE = Path(__file__).resolve().parent


def processor() -> str:
    """Return the model of the processor as Linux says it, else what Python knows."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), "unknown")


if __name__ == "__main__":
    with TemporaryDirectory() as folder:
        if code := main([*COMMAND.split(), folder]):
            raise SystemExit(code)
        (HERE / "small.jsonl").write_bytes((Path(folder) / "results.jsonl").read_bytes())
    machine = {
        "command": f"cutgap {COMMAND.removesuffix(' --out')}",
        "processor": processor(),
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.machine()}",
    }
    (HERE / "machine.json").write_text(json.dumps(machine, indent=2) + "\n", encoding="utf-8")
