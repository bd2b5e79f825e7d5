"""README as a package index shows it: its links and pictures, which are relative here, lead to the repository."""

import re
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

RELATIVE = re.compile(r"(!\[[^\]]*)?\]\((?![a-z]+:|#)")


class CustomMetadataHook(MetadataHookInterface):
    """Fills in the readme; hatchling finds the class by this name."""

    def update(self, metadata: dict[str, Any]) -> None:
        text = (Path(self.root) / "README.md").read_text(encoding="utf-8")
        address, tag = metadata["urls"]["Repository"], f"v{metadata['version']}"
        absolute = RELATIVE.sub(lambda link: f"{link[0]}{address}/{'raw' if link[1] else 'blob'}/{tag}/", text)
        metadata["readme"] = {"content-type": "text/markdown", "text": absolute}
