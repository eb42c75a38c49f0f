"""Actions: goals that take time, with feedback, a result, and cancellation."""

import threading
from typing import TYPE_CHECKING, Any, Callable, Dict, Iterator, Optional, Type

from musher import _native
from musher._errors import Failure
from musher._message import Action, Message, codec_of, type_name
from musher._node import Endpoint, _check_handler, _check_type, handling

if TYPE_CHECKING:
    from musher._node import Node

# As in native/actions.cpp.
_ACCEPTED, _STATE, _FEEDBACK, _END, _CANCEL_REPLY = range(5)
_START, _CANCEL = range(2)
_ENDS = ("succeeded", "canceled", "aborted", "rejected", "lost")
_SUCCEEDED, _CANCELED, _ABORTED = 4, 5, 6  # action_msgs/GoalStatus


class GoalFailed(Failure):
    """A goal did not succeed: `end` is "canceled", "aborted", "rejected" or "lost"."""

    def __init__(self, end: str, reason: str, result: Optional[Message]) -> None:
        super().__init__(101, f"the goal was {end}" + (f": {reason}" if reason else ""))
        self.end = end
        self.result = result


class GoalCanceled(Exception):
    """Raised by the handler of a goal that was cancelled, with the result so far."""

    def __init__(self, result: Optional[Message] = None) -> None:
        super().__init__(result)
        self.result = result


class Goal:
    """A goal that was sent: iterate over its feedback, then result(); or only result()."""

    def __init__(self, client: "ActionClient", action: Any) -> None:
        self._client = client
        self._action = action
        self._mailbox = _native.Mailbox()
        self._end: Optional[_native.Item] = None
        self._id = b""

    def __iter__(self) -> Iterator[Any]:
        while self._end is None:
            feedback = self._next(None)
            if feedback is not None:
                yield feedback

    def _next(self, timeout_s: Optional[float]) -> Any:
        """The next feedback; None after another event, or this time."""
        try:
            item = self._mailbox.pop(timeout_s)
        except StopIteration:
            raise Failure(103, "the action client is closed") from None
        if item is not None and item.kind == _END:
            self._end = item
        if item is None or item.kind != _FEEDBACK:
            return None
        message = item.decode(codec_of(self._action.FeedbackMessage), False)
        return None if message is None else message.feedback

    def result(self, timeout_s: Optional[float] = None) -> Any:
        """Waits for the Result. Raises musher.GoalFailed if the goal did not succeed, and musher.Failure after
        this time; the goal then goes on."""
        import time
        end = None if timeout_s is None else time.monotonic() + timeout_s
        while self._end is None:
            left = None if end is None else end - time.monotonic()
            if left is not None and left <= 0:
                raise Failure(107, f"the goal has not ended after {timeout_s} s")
            self._next(left)
        response = self._end.decode(codec_of(self._action.GetResult.Response), True)
        result = None if response is None else response.result
        name = _ENDS[self._end.code]
        if name == "succeeded" and result is not None:
            return result
        raise GoalFailed(name, self._end.text, result)

    def cancel(self, timeout_s: float = 5.0) -> None:
        """Requests its cancellation; the result then says whether it was cancelled."""
        mailbox = _native.Mailbox()
        self._client._open().cancel(self._id, timeout_s, mailbox, 0)
        reply = mailbox.pop(None)
        if reply is not None and reply.code != 0 and self._end is None:
            raise Failure(reply.code, reply.text or "the server rejects the cancel request")


class ActionClient(Endpoint):
    def __init__(self, node: "Node", name: str, action: Type[Action]) -> None:
        _check_type(action, Action, "an action class")
        super().__init__(node)
        self._action: Any = action
        if node._native is not None:
            self._native = _native.ActionClient(node._native, name, action._dds_type)

    @property
    def ready(self) -> bool:
        native = self._open()
        return native is not None and bool(native.ready())

    def send(self, goal: Message, timeout_s: float = 5.0) -> Goal:
        """Sends a goal. Without a server that accepts it within this time it is lost."""
        native = self._open()
        if native is None:
            raise Failure(103, "a fault-injection test has no actions")
        sent = Goal(self, self._action)
        sent._id = native.send(codec_of(self._action.Goal), goal, timeout_s, sent._mailbox, 0)
        return sent


class ServerGoal:
    """A goal on its server."""

    def __init__(self, server: "ActionServer", token: int, request: Any) -> None:
        self._server = server
        self._token = token
        self._id = request.goal_id
        self.goal: Any = request.goal
        self._cancel = threading.Event()

    @property
    def cancel_requested(self) -> bool:
        """Whether to stop: raise musher.GoalCanceled(result)."""
        return self._cancel.is_set() or self._server._closed

    def wait_for_cancel(self, timeout_s: float) -> bool:
        """Waits, at most so long, for a cancel request; returns whether there is one."""
        return self._cancel.wait(timeout_s) or self._server._closed

    @property
    def client(self) -> str:
        """What its client says of itself, for people: "alice@dog1" (a command line), "/planner" (a node), or a process;
        empty: nothing."""
        try:
            return str(self._server._open().client_of(self._token))
        except Failure:  # the server is closed
            return ""

    def feedback(self, feedback: Message) -> None:
        message_type = self._server._action.FeedbackMessage
        message = message_type(goal_id=self._id, feedback=feedback)
        self._server._open().feedback(self._token, codec_of(message_type), message)


def _not_started(response: Any) -> Any:
    """The reply for a goal that is cancelled before its start, as in transport/action.hpp."""
    made = response()
    for field in ("error_msg", "message"):
        if isinstance(getattr(made.result, field, None), str):
            setattr(made.result, field, "cancelled before it started")
            break
    return made


class ActionServer(Endpoint):
    """Each goal runs on a thread of its own; what the handler returns is the result of a goal that has succeeded.
    musher.GoalCanceled ends it as canceled, any other exception as aborted."""

    def __init__(self, node: "Node", name: str, action: Type[Action],
                 handler: Callable[[ServerGoal], Any]) -> None:
        _check_type(action, Action, "an action class")
        _check_handler(handler, "an action")
        super().__init__(node)
        self._action: Any = action
        self._name = name
        self._handler = handler
        self._goals: Dict[int, ServerGoal] = {}
        if node._native is not None:
            response = self._action.GetResult.Response
            self._native = _native.ActionServer(node._native, name, action._dds_type, codec_of(response), response(),
                                                _not_started(response), node._mailbox, self._handled_by(self._on_item))

    def _on_item(self, item: _native.Item) -> None:
        if self._closed:
            return
        if item.kind == _CANCEL:
            goal = self._goals.get(item.token)
            if goal is not None:
                goal._cancel.set()
            return
        request = item.decode(codec_of(self._action.SendGoal.Request), True)
        if request is None:
            self._node.log.warning(f"action {self._name}: a goal is malformed")
            self._finish(item.token, _ABORTED, None)
            return
        goal = self._goals[item.token] = ServerGoal(self, item.token, request)
        self._native.execute(item.token)
        try:
            threading.Thread(target=self._work, args=(goal, item), daemon=True, name=f"action {self._name}").start()
        except RuntimeError:  # no thread is left
            self._node.log.exception(f"action {self._name}: a goal cannot be run; it is aborted")
            self._finish(item.token, _ABORTED, None)

    def _work(self, goal: ServerGoal, item: _native.Item) -> None:
        state, result = _ABORTED, None
        try:
            with handling(item):
                result = self._handler(goal)
            if isinstance(result, self._action.Result):
                state = _SUCCEEDED
            else:
                self._node.log.error(f"action {self._name}: the handler returned {result!r}, not a "
                                     f"{type_name(self._action.Result)}; the goal is aborted")
                result = None
        except GoalCanceled as canceled:
            state, result = (_CANCELED if goal._cancel.is_set() else _ABORTED), canceled.result
        except BaseException:  # also sys.exit(): its client waits for the end of the goal
            self._node.log.exception(f"action {self._name}: the handler raised an exception; the goal is aborted")
        try:
            self._finish(goal._token, state, result)
        except Exception:
            if not self._closed:
                self._node.log.exception(f"action {self._name}: the result of a goal could not be sent")
                self._finish(goal._token, _ABORTED, None)

    def _finish(self, token: int, state: int, result: Any) -> None:
        response = self._action.GetResult.Response()
        if result is not None:
            response.result = result
        if not self._closed:
            self._native.end(token, state, codec_of(type(response)), response)
        self._goals.pop(token, None)
