"""Adds the descriptors of the coordinator's service to what pyproject.toml describes."""
import runpy
import shutil
import sys
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

MESSAGES = Path(__file__).parent / "parallax_data" / "_messages.py"


class BuildWithDescriptors(build_py):
    def run(self):
        super().run()
        if getattr(self, "editable_mode", False):
            return  # It runs from the clone, where protoc makes them.
        try:
            descriptors = runpy.run_path(str(MESSAGES))["compiled"]()
        except OSError as error:  # The reader works without.
            print(f"parallax_data.Client will not work: {error}", file=sys.stderr)
        else:
            (Path(self.build_lib) / "parallax_data" / "service.descriptors").write_bytes(descriptors)


setup(cmdclass={"build_py": BuildWithDescriptors}, setup_requires=[] if shutil.which("protoc") else ["grpcio-tools"])
