"""Makes anew what is made from the code and kept beside it: parts of pages, and the schema of scenes.

python docs/make.py makes them from the code of this repository, and prints which files have changed.
"""

import json
import sys
from pathlib import Path

DOCS = Path(__file__).parent
sys.path[:0] = [str(DOCS / "ext"), str(DOCS.parent)]

from reference import pages  # noqa: E402

from camopt.scene.schema import scene_schema  # noqa: E402


def made() -> dict[Path, str]:
    """The files with their texts as they should be."""
    schema = json.dumps(scene_schema(), indent=2, ensure_ascii=False) + "\n"
    return {**pages(), DOCS.parent / "camopt" / "scene" / "scene.schema.json": schema}


if __name__ == "__main__":
    changed = {file: text for file, text in made().items() if file.read_text(encoding="utf-8") != text}
    for file, text in changed.items():
        file.write_text(text, encoding="utf-8")
        print(file)
    if not changed:
        print("nothing has changed")
