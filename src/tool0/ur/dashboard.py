"""The dashboard server on port 29999; each command and each answer is one line.

Commands and answers follow UR's documentation for the e-Series and CB3:
https://www.universal-robots.com/articles/ur/dashboard-server/dashboard-server-e-series-port-29999/
https://www.universal-robots.com/articles/ur/dashboard-server/dashboard-server-cb-series-port-29999/
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import zlib
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final, final

from tool0.errors import ControlError, Tool0Error
from tool0.protocol.control_box import (
    PowerOff,
    PowerOn,
    ReleaseBrakes,
    RestartSafety,
    UnlockProtectiveStop,
)
from tool0.protocol.control_box_state import SafetyMode
from tool0.protocol.request import Request
from tool0.ur.client_interface.robot_state import robot_model
from tool0.ur.compiling import compiled
from tool0.ur.external_control import request_program
from tool0.ur.listening import REQUEST_COST, Peer, Port
from tool0.ur.program_files import ProgramFile, ProgramFiles
from tool0.ur.programs import RuntimeState

if TYPE_CHECKING:
    from tool0.ur.control_box import UrControlBox

logger = logging.getLogger(__name__)

PORT: Final = 29999
GREETING: Final = "Connected: Universal Robots Dashboard Server"
UNNAMED: Final = "<unnamed>"
"""PolyScope's name for a program that was not loaded from a file."""
NO_REPORT: Final = "Error: a simulated robot has no reports to save"
INSTALLATION: Final = "default.installation"
USER_ROLES: Final = ("programmer", "operator", "none", "locked", "restricted")
OPERATIONAL_MODES: Final = ("manual", "automatic")
CB3, E_SERIES = "CB3", "e-Series"
BOTH: Final = frozenset({CB3, E_SERIES})

SETTLE_TIMEOUT: Final = 1.0
"""Maximum time to wait for a program to pause or resume [wall s]."""
MAX_WORDS: Final = 4
"""Maximum number of words in a command."""

Answer = Callable[[str], Awaitable[str]]


@final
@dataclass(frozen=True, slots=True)
class DashboardCommand:
    """A command and the function that answers it."""

    words: str
    answer: Answer
    """Function that returns the answer to the command; its argument is the text after
    ``words``."""
    boxes: frozenset[str] = BOTH
    """Types of control boxes that support the command."""


@final
class Dashboard:
    """The dashboard server of one control box."""

    def __init__(self, box: UrControlBox, programs: Path | None = None) -> None:
        """Prepare a server for ``box`` that loads programs from ``programs``."""
        self._box, self._files = box, ProgramFiles(programs)
        self._port = Port("dashboard server", self._serve)
        self._loaded: ProgramFile | None = None
        self._mode, self._role = "NONE", "PROGRAMMER"
        series = E_SERIES if box.is_e_series else CB3
        known = (c for c in self._commands() if series in c.boxes)
        self._table = {command.words.lower(): command for command in known}

    async def start(self, host: str, port_base: int) -> None:
        """Open the port.

        Raises:
            TransportError: If the port is in use.
        """
        await self._port.listen(host, port_base + PORT)

    async def close(self) -> None:
        """Close the port and its connections."""
        await self._port.close()

    @property
    def n_clients(self) -> int:
        """Number of clients."""
        return len(self._port.peers)

    async def answer(self, line: str) -> str:
        """Execute a command and return the answer."""
        text = line.strip()
        words = text.split()
        for count in range(min(len(words), MAX_WORDS), 0, -1):
            command = self._table.get(" ".join(words[:count]).lower())
            if command is not None:
                rest = text.split(maxsplit=count)[count:]
                return await command.answer(rest[0] if rest else "")
        return f"could not understand: '{text}'"

    async def _serve(self, peer: Peer) -> None:
        peer.send(f"{GREETING}\n".encode())
        while line := await peer.reader.readline():
            text = line.decode(errors="replace")
            peer.send(f"{await self.answer(text)}\n".encode())
            if text.strip().lower() in {"quit", "shutdown"}:
                await peer.close()
                return
            await peer.account.pay(REQUEST_COST)

    def _commands(self) -> tuple[DashboardCommand, ...]:
        box, arm = self._box, self._box.arm
        request, e_series = self._requesting, frozenset({E_SERIES})
        return (
            # ---- programs ----
            DashboardCommand("load", self._load),
            DashboardCommand("play", self._play),
            DashboardCommand("stop", self._stop),
            DashboardCommand("pause", self._pause),
            DashboardCommand(
                "running", _saying(lambda _: f"Program running: {self._running}")
            ),
            DashboardCommand("get loaded program", _saying(self._loaded_program)),
            DashboardCommand("isProgramSaved", _saying(self._is_saved)),
            DashboardCommand("programState", _saying(self._program_state)),
            DashboardCommand("load installation", _saying(self._load_installation)),
            # ---- power and safety ----
            request("power on", PowerOn(arm=arm), "Powering on"),
            request("power off", PowerOff(arm=arm), "Powering off"),
            request("brake release", ReleaseBrakes(arm=arm), "Brake releasing"),
            request("restart safety", RestartSafety(arm=arm), "Restarting safety"),
            request("shutdown", PowerOff(arm=arm), "Shutting down"),
            DashboardCommand("unlock protective stop", self._unlock),
            DashboardCommand(
                "close safety popup", _saying(lambda _: "closing safety popup")
            ),
            DashboardCommand(
                "robotmode", _saying(lambda _: f"Robotmode: {self._robot_mode}")
            ),
            DashboardCommand(
                "safetymode", _saying(lambda _: f"Safetymode: {self._safety}")
            ),
            DashboardCommand(
                "safetystatus", _saying(lambda _: f"Safetystatus: {self._safety}")
            ),
            # ---- the pendant ----
            DashboardCommand("popup", _saying(self._popup)),
            DashboardCommand("close popup", _saying(self._close_popup)),
            DashboardCommand("addToLog", _saying(self._add_to_log)),
            DashboardCommand("quit", _saying(lambda _: "Disconnected")),
            DashboardCommand("set operational mode", _saying(self._set_mode), e_series),
            DashboardCommand(
                "get operational mode", _saying(lambda _: self._mode), e_series
            ),
            DashboardCommand(
                "clear operational mode", _saying(self._clear_mode), e_series
            ),
            DashboardCommand(
                "is in remote control", _saying(lambda _: "true"), e_series
            ),
            DashboardCommand(
                "setUserRole", _saying(self._set_user_role), frozenset({CB3})
            ),
            DashboardCommand(
                "getUserRole", _saying(lambda _: self._role), frozenset({CB3})
            ),
            # ---- the robot ----
            DashboardCommand(
                "PolyscopeVersion",
                _saying(lambda _: f"URSoftware {self._version} (tool0)"),
            ),
            DashboardCommand("version", _saying(lambda _: self._version), e_series),
            DashboardCommand(
                "get serial number", _saying(lambda _: serial_number(arm))
            ),
            DashboardCommand("get robot model", _saying(lambda _: robot_model(box))),
            DashboardCommand("generate flight report", _saying(lambda _: NO_REPORT)),
            DashboardCommand("generate support file", _saying(lambda _: NO_REPORT)),
            DashboardCommand("saveLog", self._save_log),
        )

    # ---- programs -------------------------------------------------------------------

    async def _load(self, name: str) -> str:
        if self._box.programs.is_running:
            return f"Error while loading program: {name}"
        found = await asyncio.to_thread(self._files.read, name)
        if found is None:
            return f"File not found: {name}"
        try:
            if found.text is not None:
                await compiled(found.text, found.name)
        except Tool0Error as error:
            self._box.report(error)
            return f"Error while loading program: {name}"
        self._loaded = found
        return f"Loading program: {name}"

    async def _play(self, _: str) -> str:
        box = self._box
        try:
            if box.programs.is_paused:
                box.programs.resume()
                await self._settle()
            elif self._loaded is None or box.programs.is_running:
                raise ControlError("no program is loaded, or one is running already")
            else:
                loaded, n_stops = self._loaded, box.programs.n_stops
                text = loaded.text
                if text is None:
                    text = await request_program(self._port.host)
                program = await compiled(text, loaded.name)
                await box.programs.start(program, n_stops)
        except Tool0Error as error:
            logger.warning("%s: play: %s", box.arm, error)
            return "Failed to execute: play"
        return "Starting program"

    async def _stop(self, _: str) -> str:
        await self._box.programs.stop()
        return "Stopped"

    async def _pause(self, _: str) -> str:
        try:
            self._box.programs.pause()
        except ControlError:
            return "Failed to execute: pause"
        await self._settle()
        return "Pausing program"

    async def _settle(self) -> None:
        """Wait until the control box has paused or resumed the program."""
        programs = self._box.programs
        changing = (RuntimeState.PAUSING, RuntimeState.RESUMING)
        settled = self._box.until(lambda: programs.state not in changing)
        with contextlib.suppress(asyncio.TimeoutError):  # time does not advance
            await asyncio.wait_for(settled, SETTLE_TIMEOUT)

    @property
    def _name(self) -> str:
        return UNNAMED if self._loaded is None else self._loaded.name

    @property
    def _running(self) -> str:
        return str(self._box.programs.state is RuntimeState.PLAYING).lower()

    def _loaded_program(self, _: str) -> str:
        if self._loaded is None:
            return "No program loaded"
        return f"Loaded program: {self._loaded.name}"

    def _is_saved(self, _: str) -> str:
        return f"{str(self._loaded is not None).lower()} {self._name}"

    def _program_state(self, _: str) -> str:
        match self._box.programs.state:
            case RuntimeState.PLAYING | RuntimeState.PAUSING | RuntimeState.RESUMING:
                return f"PLAYING {self._name}"
            case RuntimeState.PAUSED:
                return f"PAUSED {self._name}"
        return f"STOPPED {self._name}"

    async def _save_log(self, _: str) -> str:
        try:
            await asyncio.to_thread(self._files.save_log, tuple(self._box.messages.log))
        except OSError as error:
            return f"Error while saving log: {error}"
        return "Log saved to disk"

    def _load_installation(self, name: str) -> str:
        if name == INSTALLATION:
            return f"Loading installation: {name}"
        return f"File not found: {name}"

    # ---- modes ----------------------------------------------------------------------

    def _requesting(
        self, words: str, request: Request[None], done: str
    ) -> DashboardCommand:
        """Return a command that sends a request to the bring-up."""

        async def answer(_: str) -> str:
            try:
                await self._box.call(request)
            except ControlError as error:
                self._box.report(error)
                return f"Failed to execute: {words}"
            return done

        return DashboardCommand(words, answer)

    async def _unlock(self, _: str) -> str:
        if self._box.state.safety_mode is SafetyMode.PROTECTIVE_STOP:
            try:
                await self._box.call(UnlockProtectiveStop(arm=self._box.arm))
            except ControlError as error:
                return str(error)
        return "Protective stop releasing"

    @property
    def _robot_mode(self) -> str:
        return self._box.state.robot_mode.name

    @property
    def _safety(self) -> str:
        return self._box.state.safety_mode.name

    def _set_mode(self, mode: str) -> str:
        if mode.lower() not in OPERATIONAL_MODES:
            return f"Failed setting operational mode: {mode}"
        self._mode = mode.upper()
        return f"Operational mode '{self._mode}' is set"

    def _clear_mode(self, _: str) -> str:
        mode, self._mode = self._mode, "NONE"
        return (
            "No longer controlling the operational mode. Current operational mode: "
            f"'{mode}'."
        )

    def _set_user_role(self, role: str) -> str:
        if role.lower() not in USER_ROLES:
            return f"Failed setting user role: {role}"
        self._role = role.upper()
        return f"Setting user role: {self._role}"

    # ---- the pendant ----------------------------------------------------------------

    def _popup(self, text: str) -> str:
        self._box.messages.show_popup(text, "Message")
        return "showing popup"

    def _close_popup(self, _: str) -> str:
        self._box.messages.close_popup()
        return "closing popup"

    def _add_to_log(self, text: str) -> str:
        if not text:
            return "No log message to add"
        logger.info("%s: %s", self._box.arm, text)
        self._box.messages.note(text)
        return "Added log message"

    @property
    def _version(self) -> str:
        return ".".join(map(str, (*self._box.version, 0)))


def serial_number(arm: str) -> str:
    """Return a serial number that depends only on the arm's name."""
    return f"2024{zlib.crc32(arm.encode()) % 10**7:07d}"


def _saying(answer: Callable[[str], str]) -> Answer:
    async def say(rest: str) -> str:
        return answer(rest)

    return say
