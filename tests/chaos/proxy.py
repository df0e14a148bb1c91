"""A TCP proxy with faults, between workers or clients and their coordinator.

It understands the messages, and drops, repeats, reorders, corrupts and delays them. It cuts connections between messages
and in the middle of one. It freezes (passes nothing and loses nothing, as in a partition shorter than TCP's timeout) and
swallows (accepts everything and passes nothing, as on a half-open connection). The faults of a connection depend on the
seed, the connection's number and its direction."""

import asyncio
import collections
import contextlib
import dataclasses
import random
import threading

import wire


@dataclasses.dataclass(frozen=True)
class Faults:
    """Shares of all messages, 0 to 1; `delay` is the longest delay in seconds. `corrupt` changes a bit of a message's bulk
frame, `garble` a bit of its control frame."""

    drop: float = 0
    repeat: float = 0
    reorder: float = 0
    corrupt: float = 0
    garble: float = 0
    delay: float = 0


class Proxy:
    """with Proxy(("127.0.0.1", 7400), seed) as proxy: ...

    The proxy runs in a separate thread. Any thread may call its methods. `rewrite(up, frames)`, if given, returns the
frames to pass on instead; `up` is True for messages to the coordinator. The coordinator sees connections from the
address `source`, if given."""

    def __init__(self, target, seed, rewrite=None, source=None):
        self.target = target
        self.source = source
        self.seed = seed
        self.rewrite = rewrite
        self.faults = Faults()
        self.counts = collections.Counter()
        self._connections = {}  # number: the two writers
        self._torn = set()  # (connection, direction) that is cut within its next message
        self._swallowing = False
        self._loop = asyncio.new_event_loop()
        self._flowing = asyncio.Event()
        self._flowing.set()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)

    def __enter__(self):
        self._thread.start()
        self._server = self._call(asyncio.start_server(self._serve, "127.0.0.1", 0))
        self.address = "tcp://127.0.0.1:%d" % self._server.sockets[0].getsockname()[1]
        return self

    def __exit__(self, *_):
        self._call(self._stop())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()

    def cut(self):
        """Closes every connection."""
        self._call(self._cut())

    def tear(self):
        """Cuts every connection in the middle of its next message, in each direction."""
        self._call(self._tear())

    def freeze(self, frozen):
        self._loop.call_soon_threadsafe(self._flowing.clear if frozen else self._flowing.set)

    def swallow(self, swallowing):
        """Begins or ends swallowing. At the end, closes the connections, whose messages are lost."""
        self._swallowing = swallowing
        if not swallowing:
            self.cut()

    def calm(self):
        """Ends all faults. Cuts the connections that have lost bytes."""
        self.faults = Faults()
        self._torn.clear()
        self.freeze(False)
        if self._swallowing:
            self.swallow(False)

    def _call(self, coroutine):
        return asyncio.run_coroutine_threadsafe(coroutine, self._loop).result(timeout=60)

    async def _stop(self):
        self._server.close()
        tasks = asyncio.all_tasks() - {asyncio.current_task()}
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    async def _cut(self):
        self.counts["cuts"] += len(self._connections)
        for writers in self._connections.values():
            for writer in writers:
                writer.transport.abort()

    async def _tear(self):
        self._torn.update((number, up) for number in self._connections for up in (True, False))

    async def _serve(self, reader, writer):
        self.counts["connections"] += 1
        number = self.counts["connections"]
        writers = self._connections[number] = [writer]
        try:
            while self._swallowing and await reader.read(65536):
                pass
            far_reader, far_writer = await asyncio.open_connection(
                *self.target, local_addr=self.source and (self.source, 0))
            writers.append(far_writer)
            pumps = [asyncio.ensure_future(self._pump(number, True, reader, far_writer)),
                     asyncio.ensure_future(self._pump(number, False, far_reader, writer))]
            try:
                await asyncio.wait(pumps, return_when=asyncio.FIRST_COMPLETED)
            finally:
                for pump in pumps:
                    pump.cancel()
                await asyncio.gather(*pumps, return_exceptions=True)
        except OSError:
            pass  # the coordinator is away, or the connection was reset
        finally:
            del self._connections[number]
            for writer in writers:
                writer.close()

    async def _pump(self, number, up, reader, writer):
        with contextlib.suppress(OSError, asyncio.IncompleteReadError):
            await self._pass_greeting(reader, writer)
            dice = random.Random(f"{self.seed} {number} {up}")
            held = []  # messages that let the next one go first
            while True:
                command, frames = await wire.read_message(reader)
                if command:
                    await self._send(number, up, writer, True, frames)
                    continue
                if self.rewrite:
                    frames = self.rewrite(up, frames)
                for message in self._mangled(dice, held, frames):
                    await asyncio.sleep(dice.uniform(0, self.faults.delay))
                    await self._send(number, up, writer, False, message)

    async def _pass_greeting(self, reader, writer):
        """Passes on the greeting byte by byte, because each side waits for the beginning of the other's."""
        left = wire.GREETING_BYTES
        while left > 0:
            part = await reader.read(left)
            if not part:
                raise ConnectionError
            left -= len(part)
            await self._flowing.wait()
            writer.write(part)

    async def _send(self, number, up, writer, command, frames):
        await self._flowing.wait()
        if self._swallowing:
            self.counts["swallowed"] += 1
            return
        data = wire.encode_message(command, frames)
        if (number, up) in self._torn:
            self._torn.discard((number, up))
            self.counts["torn"] += 1
            writer.write(data[:len(data) // 2])
            writer.close()
            raise ConnectionError
        writer.write(data)
        await writer.drain()

    def _mangled(self, dice, held, frames):
        """Returns the messages to pass on now."""
        faults = self.faults
        self.counts["messages"] += 1

        def happens(what):
            hit = dice.random() < getattr(faults, what)
            self.counts[what] += hit
            return hit

        if happens("drop"):
            return []
        if len(frames) > 1 and happens("corrupt"):
            frames = [*frames[:-1], flipped(dice, frames[-1])]
        if happens("garble"):
            frames = [flipped(dice, frames[0]), *frames[1:]]
        if happens("reorder"):
            held.append(frames)
            return []
        now = [frames, frames] if happens("repeat") else [frames]
        now += held
        held.clear()
        return now


def flipped(dice, frame):
    """Returns the frame with one bit changed."""
    if not frame:
        return frame
    changed = bytearray(frame)
    changed[dice.randrange(len(frame))] ^= 1 << dice.randrange(8)
    return bytes(changed)
