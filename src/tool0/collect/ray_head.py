"""Program that starts Ray on this machine and writes Ray's address to a file."""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path


def main() -> None:
    """Start Ray with the folder and the number of processors in the arguments."""
    folder, n_processors = Path(sys.argv[1]), int(sys.argv[2])
    os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
    import ray

    ray.init(
        address="local",
        num_cpus=n_processors,
        include_dashboard=False,
        log_to_driver=False,
        _temp_dir=str(folder),
    )
    part = folder / "address.part"
    part.write_text(ray.get_runtime_context().gcs_address)
    part.rename(folder / "address")
    signal.pause()


if __name__ == "__main__":
    main()
