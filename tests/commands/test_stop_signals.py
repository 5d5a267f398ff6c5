"""Interrupts: both signals alike, and work that is to be whole is not cut."""

import contextlib
import signal

import pytest

from comotion.stop_signals import Interrupts

BOTH = pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])


@BOTH
def test_a_signal_interrupts(number):
    with pytest.raises(KeyboardInterrupt), Interrupts():
        signal.raise_signal(number)


@BOTH
def test_held_work_is_finished_first(number):
    done = []

    def work(interrupts):
        with interrupts.held():
            signal.raise_signal(number)
            done.append("whole")
        done.append("not reached")

    with pytest.raises(KeyboardInterrupt), Interrupts() as interrupts:
        work(interrupts)
    assert done == ["whole"]


@BOTH
def test_an_interrupt_that_a_library_swallowed_is_raised_again(number):
    def work(interrupts):
        with contextlib.suppress(KeyboardInterrupt):
            signal.raise_signal(number)
        with interrupts.held():
            pass

    with pytest.raises(KeyboardInterrupt), Interrupts() as interrupts:
        work(interrupts)


@BOTH
def test_handlers_are_given_back(number):
    before = signal.getsignal(number)
    with Interrupts():
        assert signal.getsignal(number) is not before
    assert signal.getsignal(number) is before
