#!/usr/bin/python3
"""Calls between this program and canorb's, frame by frame, through python-can.

usage: frames.py INTERFACE

As node 5 calls operation 7 of object 1 on node 3, prints the answer, and then serves one call as
node 6.
"""

import sys

import can

PATIENCE = 30  # seconds


def show(message):
    print(f"{message.arbitration_id:03X}#{message.data.hex().upper()}", flush=True)


with can.Bus(interface="socketcan", channel=sys.argv[1]) as bus:
    exact = 0x7FF
    bus.set_filters([{"can_id": 0b1_00101_00011, "can_mask": exact, "extended": False}])
    bus.send(
        can.Message(
            arbitration_id=0b1_00011_00101,
            data=bytes.fromhex("10 0005 ABCD 1801 07"),
            is_extended_id=False,
        )
    )
    show(bus.recv(PATIENCE))

    bus.set_filters([{"can_id": 0b1_00110_00111, "can_mask": exact, "extended": False}])
    print("serving", flush=True)
    request = bus.recv(PATIENCE)
    show(request)
    bus.send(
        can.Message(
            arbitration_id=0b1_00111_00110,
            data=bytes.fromhex("11 0003") + request.data[3:5] + b"\0",
            is_extended_id=False,
        )
    )
