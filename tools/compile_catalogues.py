"""Compile the catalogues of the languages into the wheel; a checkout compiles its own when it reads them."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import Any

from babel.messages.mofile import write_mo
from babel.messages.pofile import read_po
from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class CompiledCatalogues(BuildHookInterface):
    """What hatchling calls before and after it builds a wheel."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Put each catalogue into the wheel, compiled."""
        self.made = Path(tempfile.mkdtemp())
        if version == "editable":
            return
        root = Path(self.root)
        for source in root.glob("atleak/locale/*/LC_MESSAGES/*.po"):
            target = source.relative_to(root).with_suffix(".mo")
            compiled = self.made / "-".join(target.parts)
            with source.open("rb") as read, compiled.open("wb") as written:
                write_mo(written, read_po(read))
            build_data["force_include"][str(compiled)] = target.as_posix()

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Take away what was compiled beside the wheel."""
        shutil.rmtree(self.made)
