"""Three poses through rational-linkages: what the book sets beside kinlib's answer, kept in a file.

``python -m tests.bench.side_by_side`` writes the file again, in an environment that has rational-linkages.
"""

import json
import sys
from datetime import date
from importlib.metadata import version
from pathlib import Path
from time import process_time

import numpy as np

from kinlib.gallery import THREE_POSES

PLACE = Path(__file__).resolve().parents[2] / "book" / "beyond" / "rational_linkages.json"


def seconds_of(work):
    """What comes out, and the time of the processor that it takes."""
    start = process_time()
    result = work()
    return result, round(process_time() - start, 3)


def bennett_of_rational_linkages() -> dict:
    """The linkage of the gallery's three poses: both chains, Denavit–Hartenberg rows, times."""
    from rational_linkages import DualQuaternion, MotionInterpolation, RationalMechanism

    poses = [DualQuaternion(pose.eps_conjugate().coeffs.tolist()) for pose in THREE_POSES]
    curve, interpolating = seconds_of(lambda: MotionInterpolation.interpolate(poses))
    chains, factorizing = seconds_of(curve.factorize)
    mechanism, making = seconds_of(lambda: RationalMechanism(chains))
    rows = np.asarray(mechanism.get_dh_params(), dtype=float)
    return {
        "package": "rational-linkages",
        "version": version("rational-linkages"),
        "python": sys.version.split()[0],
        "date": date.today().isoformat(),
        "seconds": {"interpolate": interpolating, "factorize": factorizing, "mechanism": making},
        "chains": [[np.asarray(h.array(), dtype=float).tolist() for h in chain.dq_axes] for chain in chains],
        "theta, d, a, alpha": rows.tolist(),
    }


if __name__ == "__main__":
    PLACE.write_text(json.dumps(bennett_of_rational_linkages(), indent=1) + "\n", encoding="utf-8")
    print(f"wrote {PLACE}")
