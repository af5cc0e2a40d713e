"""``tool0 collect`` as a person calls it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from data_sets import POLICY
from fake_tasks import WALK
from screen import Screen

from tool0.cli import FAILED, OK, collect, main
