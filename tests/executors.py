"""An executor for tests that replace functions of the judge."""

from concurrent.futures import Executor, Future


class InlineExecutor(Executor):
    """Executor that runs jobs immediately in this process, where tests can replace functions."""

    def __init__(self, workers):
        pass

    def submit(self, function, *arguments):
        future = Future()
        try:
            future.set_result(function(*arguments))
        except Exception as error:
            future.set_exception(error)
        return future
