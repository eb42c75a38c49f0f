"""Topics and services: a participant of the robot's domain, and its endpoints.

Musher's loop receives samples without waiting for Python: they are queued, and a handler runs on the node's
Python thread, one at a time. A subscription without a handler is an iterator instead.
"""

import atexit
import collections
import contextlib
import inspect
import os
import threading
import time
import weakref
from typing import TYPE_CHECKING, Any, Callable, Deque, Dict, Generic, Iterator, Optional, Type, TypeVar

from musher import _native
from musher._errors import Failure
from musher._log import Log
from musher._message import Action, Message, Service, codec_of, type_name

M = TypeVar("M", bound=Message)
_CLOSED = 103  # Robot (100) + STATE_INVALID
_MALFORMED = 105  # + NET_ERROR
_of_thread = threading.local()  # .request: what this thread handles, see request_here()


def default_by() -> str:
    """"anna@robot (show.py)": who requests something, for the machine's history."""
    import sys
    program = os.path.basename(sys.argv[0]) if sys.argv and sys.argv[0] else "python"
    return f"{_user()}@{os.uname().nodename} ({program})"


def _user() -> str:
    """Of this process. Not by the user database, which may be on a server that does not answer: an emergency stop has
    this name, too."""
    named = next(filter(None, map(os.environ.get, ("LOGNAME", "USER", "LNAME", "USERNAME"))), "")
    if named:
        return named
    number = str(os.getuid())
    try:
        with open("/etc/passwd", encoding="utf-8", errors="replace") as users:
            of_this = (line.split(":") for line in users)
            return next((fields[0] for fields in of_this if len(fields) > 2 and fields[2] == number), number)
    except OSError:
        return number


def request_here() -> Optional[_native.Item]:
    """What this thread handles: a message, a request or a goal; None: nothing that was received."""
    request: Optional[_native.Item] = getattr(_of_thread, "request", None)
    return request


@contextlib.contextmanager
def handling(request: Optional[_native.Item]) -> Iterator[None]:
    before = request_here()
    _of_thread.request = request
    try:
        yield
    finally:
        _of_thread.request = before


class Endpoint:
    """What all endpoints have in common."""

    def __init__(self, node: "Node") -> None:
        self._node = node
        self._closed = False
        self._native: Any = None  # of musher._native; None in a fault-injection test
        self._key: Optional[int] = None  # of its handler
        node._endpoints.add(self)

    def close(self) -> None:
        """Ends it; idempotent."""
        self._closed = True
        self._node._endpoints.discard(self)
        if self._native is not None:
            self._native.close()
        if self._key is not None:
            self._node._delivery.remove(self._key)

    def _handled_by(self, on_item: Callable[[_native.Item], None]) -> int:
        """The key of its items, which this handles until it is closed."""
        self._key = self._node._handle(on_item)
        return self._key

    def _open(self) -> Any:
        if self._closed:
            raise Failure(_CLOSED, f"this {type(self).__name__} is closed")
        return self._native


class Publisher(Endpoint, Generic[M]):
    def __init__(self, node: "Node", topic: str, message_type: Type[M], reliable: bool, latched: bool,
                 depth: int) -> None:
        _check_type(message_type, Message, "a message class")
        super().__init__(node)
        self._type = message_type
        self._codec = codec_of(message_type)
        if node._native is not None:
            self._native = _native.Writer(node._native, topic, message_type._dds_type, reliable, latched, depth)

    def publish(self, message: M) -> None:
        """Sends it. Raises TypeError, with the name of the field, for a value of a wrong type."""
        native = self._open()
        if native is None:
            self._codec.encode(message)
        else:
            native.publish(self._codec, message)

    @property
    def matched(self) -> int:
        """How many subscriptions receive it."""
        native = self._open()
        return int(native.matched()) if native is not None else 0


class Subscription(Endpoint, Generic[M]):
    """With a handler: calls it with each message. Without one: iterate, or take()."""

    def __init__(self, node: "Node", topic: str, message_type: Type[M], handler: Optional[Callable[[M], None]],
                 reliable: bool, latched: bool, depth: int) -> None:
        _check_type(message_type, Message, "a message class")
        if handler is not None:
            _check_handler(handler, "a subscription")
        super().__init__(node)
        self._type = message_type
        self._codec = codec_of(message_type)
        #: Samples that were not of this type, and were dropped.
        self.malformed = 0
        self._mailbox = _native.Mailbox() if handler is None else node._mailbox
        self._own_mailbox = handler is None
        key = self._handled_by(self._on_item(handler)) if handler is not None else 0
        if node._native is not None:
            self._native = _native.Reader(node._native, topic, message_type._dds_type, reliable, latched, depth,
                                          self._mailbox, key)

    def _on_item(self, handler: Callable[[M], None]) -> Callable[[_native.Item], None]:
        def on_item(item: _native.Item) -> None:
            message = self._decode(item)
            if message is not None and not self._closed:
                handler(message)
        return on_item

    def _decode(self, item: _native.Item) -> Optional[M]:
        message: Optional[M] = item.decode(self._codec, False)
        if message is None:
            self.malformed += 1
        return message

    def take(self, timeout_s: Optional[float] = None) -> Optional[M]:
        """The next message; None after this time without one (no time: waits for ever)."""
        if not self._own_mailbox:
            raise Failure(_CLOSED, "this subscription has a handler, which gets its messages")
        self._open()
        end = None if timeout_s is None else time.monotonic() + timeout_s
        left = timeout_s
        while True:
            try:
                item = self._mailbox.pop(left)
            except StopIteration:
                raise Failure(_CLOSED, "this subscription is closed") from None
            if item is None:
                return None
            message = self._decode(item)
            if message is not None:
                return message
            left = None if end is None else max(end - time.monotonic(), 0.0)

    def __iter__(self) -> Iterator[M]:
        while not self._closed:
            try:
                message = self.take()
            except Failure:
                if self._closed:
                    return
                raise
            if message is not None:
                yield message

    def close(self) -> None:
        super().close()
        if self._own_mailbox:
            self._mailbox.close()

    @property
    def dropped(self) -> int:
        """Messages dropped because they were not taken in time (without a handler)."""
        return self._mailbox.dropped() if self._own_mailbox else 0

    @property
    def matched(self) -> int:
        """How many publishers it receives from."""
        native = self._open()
        return int(native.matched()) if native is not None else 0


class ServiceClient(Endpoint):
    def __init__(self, node: "Node", name: str, service: Type[Service]) -> None:
        _check_type(service, Service, "a service class")
        super().__init__(node)
        self._service: Any = service
        self._matches = _native.Mailbox()
        if node._native is not None:
            self._native = _native.ServiceClient(node._native, name, service._dds_type, self._matches)

    @property
    def ready(self) -> bool:
        """Whether a server is connected; a call waits for one."""
        native = self._open()
        return native is not None and bool(native.ready())

    def wait_until_ready(self, timeout_s: float) -> bool:
        """Waits for a server, at most so long; returns whether there is one."""
        end = time.monotonic() + timeout_s
        while not self.ready:
            left = end - time.monotonic()
            if left <= 0:
                return False
            self._matches.pop(left)
        return True

    def call(self, request: Message, timeout_s: float = 5.0) -> Any:
        """Returns the Response. Raises musher.Failure: no server, or no reply in time."""
        native = self._open()
        codec = codec_of(self._service.Request)
        if native is None:
            codec.encode(request)
            return self._service.Response()
        mailbox = _native.Mailbox()
        native.call(codec, request, timeout_s, mailbox, 0)
        item = mailbox.pop(None)
        assert item is not None
        if item.code != 0:
            raise Failure(item.code, item.text)
        response = item.decode(codec_of(self._service.Response), True)
        if response is None:
            raise Failure(_MALFORMED, f"the reply is not a {type_name(self._service.Response)}")
        return response


class ServiceServer(Endpoint):
    def __init__(self, node: "Node", name: str, service: Type[Service], handler: Callable[[Any], Any]) -> None:
        _check_type(service, Service, "a service class")
        _check_handler(handler, "a service")
        super().__init__(node)
        self._name = name
        self._service: Any = service
        self._handler = handler
        if node._native is not None:
            self._native = _native.ServiceServer(node._native, name, service._dds_type, node._mailbox,
                                                 self._handled_by(self._on_request))

    def _on_request(self, item: _native.Item) -> None:
        if self._closed:
            return
        request = item.decode(codec_of(self._service.Request), True)
        replied = False
        try:
            if request is None:
                self._node.log.warning(f"service {self._name}: a request is malformed")
                return
            response = self._handler(request)
            if not isinstance(response, self._service.Response):
                self._node.log.error(f"service {self._name}: the handler returned {response!r}, not a "
                                     f"{type_name(self._service.Response)}; the client gets no reply")
                return
            self._native.reply(item.token, codec_of(self._service.Response), response)
            replied = True
        finally:
            if not replied and not self._closed:
                self._native.forget(item.token)


class Node:
    """A participant of the robot's domain. An actuator has one: self.node.

        with musher.Node() as node:
            chat = node.publisher("chat", String)
            chat.publish(String("hello"))

    `namespace` goes before relative names ("/chat" has none); the default is $MUSHER_NAMESPACE. `domain`: of
    DDS; the default is $ROS_DOMAIN_ID. `keys`: the folder with the credentials of `identity`, for a machine
    with [security]; the defaults are $MUSHER_KEYS and $MUSHER_IDENTITY. `interface`: the one network, such as
    "wlan0", by which it reaches other hosts with MUSHER_TRANSPORT=lan; the default are those that Musher chooses.
    """

    def __init__(self, name: str = "", *, namespace: Optional[str] = None, domain: Optional[int] = None,
                 keys: str = "", identity: str = "", interface: str = "") -> None:
        if namespace is None:
            namespace = os.environ.get("MUSHER_NAMESPACE", "")
        keys = keys or os.environ.get("MUSHER_KEYS", "")
        identity = identity or os.environ.get("MUSHER_IDENTITY", "operator")
        keys = os.path.abspath(keys) if keys else ""
        native = _native.Node(name, namespace, domain, keys, identity, interface)
        #: With what another process joins the same domain: the arguments of musher._native.publish_stop().
        self._joined_with = [namespace, "" if domain is None else str(domain), keys, identity, interface]
        self._start(native, Log(name))

    @classmethod
    def _of(cls, native: Optional[_native.Node], log: Log) -> "Node":
        node = cls.__new__(cls)
        node._start(native, log)
        return node

    def _start(self, native: Optional[_native.Node], log: Log) -> None:
        self._native = native  # None: of a fault-injection test, which has no transport
        self.log = log
        self._mailbox = _native.Mailbox()
        self._delivery = _Delivery(self._mailbox, log)
        self._endpoints: "set[Endpoint]" = set()
        self._thread: Optional[threading.Thread] = None
        self._lock = threading.Lock()
        self._open = True
        _nodes.add(self)

    @property
    def namespace(self) -> str:
        return self._native.name_space() if self._native is not None else ""

    def publisher(self, topic: str, message_type: Type[M], *, reliable: bool = True, latched: bool = False,
                  depth: int = 10) -> Publisher[M]:
        """`latched`: a later subscription gets the last samples, too (ROS 2: transient local)."""
        self._check(topic)
        return Publisher(self, topic, message_type, reliable, latched, _checked_depth(depth))

    def subscribe(self, topic: str, message_type: Type[M], handler: Optional[Callable[[M], None]] = None, *,
                  reliable: bool = True, latched: bool = False, depth: int = 10) -> Subscription[M]:
        """Calls the handler on the node's thread; without one, iterate over the subscription. `reliable`
        receives only from reliable publishers: a sensor's topic mostly needs reliable=False."""
        self._check(topic)
        return Subscription(self, topic, message_type, handler, reliable, latched, _checked_depth(depth))

    def client(self, name: str, service: Type[Service]) -> ServiceClient:
        self._check(name)
        return ServiceClient(self, name, service)

    def serve(self, name: str, service: Type[Service], handler: Callable[[Any], Any]) -> ServiceServer:
        """Offers a service: the handler gets each Request, on the node's thread, and returns the Response."""
        self._check(name)
        return ServiceServer(self, name, service, handler)

    def action_client(self, name: str, action: Type[Action]) -> "ActionClient":
        from musher._action import ActionClient
        self._check(name)
        return ActionClient(self, name, action)

    def serve_action(self, name: str, action: Type[Action],
                     handler: "Callable[[ServerGoal], Any]") -> "ActionServer":
        """Offers an action: the handler gets each goal, on a thread of its own, and returns the Result."""
        from musher._action import ActionServer
        self._check(name)
        return ActionServer(self, name, action, handler)

    def close(self) -> None:
        """Closes its endpoints; a handler that runs may go on to its end. Idempotent."""
        self._open = False
        for endpoint in list(self._endpoints):
            endpoint.close()
        self._mailbox.close()
        thread = self._thread
        if thread is not None and thread is not threading.current_thread():
            thread.join(2.0)
        self._native = None if thread is None or not thread.is_alive() else self._native
        _nodes.discard(self)

    def __enter__(self) -> "Node":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _check(self, name: str) -> None:
        if not isinstance(name, str) or not name:
            raise TypeError(f"the name of a topic or service is a str such as \"door/opening\", not {name!r}")
        if not self._open:
            raise Failure(_CLOSED, f"the node is closed; '{name}' cannot be opened")

    def _handle(self, on_item: Callable[[_native.Item], None]) -> int:
        with self._lock:
            key = self._delivery.add(on_item)
            if self._thread is None and self._native is not None:
                self._thread = threading.Thread(target=self._delivery.run, daemon=True, name="musher node")
                self._thread.start()
        return key

    def _run(self, work: Callable[[], None], first: bool = False) -> None:
        """Runs work on the node's thread, between two handlers or as the next thing there, and waits for it. In a
        fault-injection test, which has no such thread, here."""
        if self._native is None or threading.current_thread() is self._thread:
            return work()
        job = self._post(work, first)
        job.done.wait()
        if job.error is not None:
            raise job.error

    def _post(self, work: Callable[[], None], first: bool = False) -> "_Job":
        """The same without waiting; in a fault-injection test it does not run."""
        job = _Job(work)
        if self._native is not None:
            if self._thread is None:
                self._handle(lambda item: None)  # starts the thread
            self._delivery.post(job, first)
        return job


class _Job:
    """Work for a node's thread."""

    def __init__(self, work: Callable[[], None]) -> None:
        self._work = work
        self._request = request_here()  # of the thread that waits for it
        self.done = threading.Event()
        self.error: Optional[BaseException] = None

    def run(self) -> None:
        try:
            with handling(self._request):
                self._work()
        except BaseException as error:
            self.error = error
        self.done.set()

    def abandon(self) -> None:
        self.error = Failure(_CLOSED, "the node is closed")
        self.done.set()


class _Delivery:
    """What a node's thread does: handles the items of the mailbox and the jobs, one at a time. It does not refer to the
    node, which thus can end."""

    _JOBS = 0  # the key of their items

    def __init__(self, mailbox: _native.Mailbox, log: Log) -> None:
        self._mailbox = mailbox
        self._log = log
        self._handlers: Dict[int, Callable[[_native.Item], None]] = {self._JOBS: self._run_job}
        self._last_key = self._JOBS
        self._jobs: Deque[_Job] = collections.deque()
        self._lock = threading.Lock()
        self._ended = False
        self._longest_s = 0.0
        self._began_s: Optional[float] = None  # the present handler, or the part of it that does not count yet
        #: Called around each handler, with whether it begins.
        self.watch: Callable[[bool], None] = lambda busy: None

    def add(self, on_item: Callable[[_native.Item], None]) -> int:
        """Returns the key of its items. Not from two threads at a time."""
        self._last_key += 1  # no key is used twice: items of a closed endpoint may still wait
        self._handlers[self._last_key] = on_item
        return self._last_key

    def remove(self, key: int) -> None:
        """Drops the items of this key that still come; idempotent."""
        self._handlers.pop(key, None)

    def post(self, job: _Job, first: bool) -> None:
        with self._lock:
            if self._ended:
                return job.abandon()
            if first:
                self._jobs.appendleft(job)
            else:
                self._jobs.append(job)
            self._mailbox.wake(self._JOBS, first)

    def take_longest_s(self) -> float:
        """For how long at most one of its handlers and jobs has run since the last call."""
        self._count()
        longest_s, self._longest_s = self._longest_s, 0.0
        return longest_s

    def _count(self) -> None:
        now_s = _since_boot_s()
        if self._began_s is not None:
            self._longest_s = max(self._longest_s, now_s - self._began_s)
            self._began_s = now_s

    def leave_to_parent(self) -> None:
        """In a fork, where no thread handles anything; also not one that has forked in a handler."""
        self._lock = threading.Lock()  # another thread may have had it
        self._ended = True
        self._jobs.clear()
        self.watch = lambda busy: None

    def run(self) -> None:
        try:
            while not self._ended:
                try:
                    item = self._mailbox.pop(None)
                except StopIteration:
                    break
                if item is not None:
                    self._handle(item)
        finally:
            with self._lock:
                self._ended = True
                for job in self._jobs:
                    job.abandon()

    def _handle(self, item: _native.Item) -> None:
        handler = self._handlers.get(item.key)
        if handler is None:
            return
        self.watch(True)
        self._began_s = _since_boot_s()
        try:
            with handling(None if item.key == self._JOBS else item):
                handler(item)
        except BaseException:  # also sys.exit(): without this thread no emergency stop would be handled
            self._log.exception("a handler raised an exception")
        finally:
            self._count()
            self._began_s = None
            self.watch(False)

    def _run_job(self, item: _native.Item) -> None:
        with self._lock:
            job = self._jobs.popleft()
        job.run()


def _since_boot_s() -> float:
    """A suspension of the computer counts."""
    return time.clock_gettime(time.CLOCK_BOOTTIME)


def _check_handler(handler: Any, what: str) -> None:
    if not callable(handler):
        raise TypeError(f"the handler of {what} is a function, not {handler!r}")
    if inspect.iscoroutinefunction(handler):
        raise TypeError(f"the handler of {what} is a function without async, not {handler!r}, which no loop would run")


def _check_type(given: Any, base: type, what: str) -> None:
    if isinstance(given, type) and issubclass(given, base):
        name: Any = getattr(given, "_dds_type", "")
        if name:
            return
    raise TypeError(f"{what} is expected, such as those in musher.std_msgs.msg, not {given!r}")


def _checked_depth(depth: int) -> int:
    if isinstance(depth, int) and 0 <= depth <= 100_000:
        return depth
    raise ValueError(f"depth is how many samples are kept, 0 (all) to 100000, not {depth!r}")


_nodes: "weakref.WeakSet[Node]" = weakref.WeakSet()


def _leave_to_parent() -> None:
    for node in list(_nodes):
        node._delivery.leave_to_parent()


os.register_at_fork(after_in_child=_leave_to_parent)


@atexit.register
def _end() -> None:
    for node in list(_nodes):
        node.close()



if TYPE_CHECKING:
    from musher._action import ActionClient, ActionServer, ServerGoal
