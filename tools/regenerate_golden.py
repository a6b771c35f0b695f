"""Write tests/golden anew, after a change of the public surface that is meant.

python tools/regenerate_golden.py
"""

from __future__ import annotations

from pathlib import Path

import public_surface

GOLDEN = Path(__file__).resolve().parents[1] / "tests" / "golden"


def main() -> None:
    target = GOLDEN / "public_surface.txt"
    target.parent.mkdir(exist_ok=True)
    target.write_text(public_surface.describe() + "\n", encoding="utf-8")
    print(f"{target}: written. Read the difference before you commit it.")


if __name__ == "__main__":
    main()
