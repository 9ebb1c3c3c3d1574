"""The files that the tests read. MAKE_EXPORTS is the program that writes them (tests/worker/dataset)."""

import os
import subprocess
import tempfile
import unittest
from pathlib import Path

from parallax_data import ParallaxDataset


class ExportsCase(unittest.TestCase):
    """A synthetic archive and its exports in every layout, made once for the class in a folder of its own."""

    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.root = Path(cls.temporary.name)
        subprocess.run([os.environ["MAKE_EXPORTS"], str(cls.root)], check=True)
        cls.data = ParallaxDataset(cls.root / "archive")
        cls.frames = {(f.scene, f.rig): f for f in cls.data.frames}

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def setUp(self):
        self.frames = {(f.scene, f.rig): f for f in self.data.frames}

    def sequences(self):
        data = ParallaxDataset(self.root / "archive_sequences")
        self.assertEqual(len(data), 8)
        sequences = data.sequences()
        self.assertEqual([[(f.scene, f.rig) for f in frames] for frames in sequences],
                         [[(0, 0), (0, 1), (0, 2), (0, 3)], [(1, 0), (1, 1), (1, 2), (1, 3)]])
        return sequences
