"""Under which names the dashboard answers."""

from __future__ import annotations

import socket

import pytest

from atleak.network import answered_names, is_here_alone

OF_MACHINE = ("127.0.0.1", "192.168.1.5", "fe80::1%eth0")


@pytest.mark.parametrize("name", ["localhost", "LOCALHOST", "127.0.0.1", "127.0.0.2", "::1"])
def test_names_of_this_machine_alone(name: str) -> None:
    assert is_here_alone(name)


@pytest.mark.parametrize("name", ["0.0.0.0", "::", "192.168.1.5", "shop.example", "localhost.example", ""])
def test_every_other_name_may_lead_others_here(name: str) -> None:
    assert not is_here_alone(name)


def test_a_dashboard_of_every_interface_answers_under_each_of_its_addresses_and_its_name() -> None:
    names = answered_names("0.0.0.0", OF_MACHINE, [])
    assert {"192.168.1.5", "fe80::1", "localhost", "127.0.0.1", "::1"} < set(names)
    assert names[0] == socket.gethostname().casefold()
    assert "0.0.0.0" not in names
    assert "shop.example" not in names


def test_a_dashboard_of_one_address_answers_there_and_under_names_that_were_given() -> None:
    names = answered_names("192.168.1.5", ("127.0.0.1", "192.168.1.5", "10.0.0.2"), ["Shop.example"])
    assert names[:2] == ("shop.example", "192.168.1.5")
    assert "10.0.0.2" not in names
