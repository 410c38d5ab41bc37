"""A CiA 402 slave that is not ours: python-canopen's local node (its SDO server, NMT slave, heartbeat and PDO
mapping), with the smallest drive in it that follows a position at every SYNC."""

import struct

import canopen

# What a controlword asks for (bits 0 to 3), and the statusword of the state it leads to.
DISABLED, READY, SWITCHED_ON, ENABLED = 0x0240, 0x0221, 0x0223, 0x0227
FOLLOWS = 1 << 12


class LocalDrive:
    def __init__(self, network, node_id, sheet):
        self.network = network
        self.node = canopen.LocalNode(node_id, sheet)
        network.add_node(self.node)
        self.status, self.position, self.enabled_syncs = DISABLED, 0, 0
        self.waiting = None
        self.syncs = 0
        self.positions = []
        self.rpdo_cob = None
        self.node.add_read_callback(self.on_read)
        network.subscribe(0, self.on_nmt)
        network.subscribe(0x80, self.on_sync)

    def on_read(self, index, subindex, od):
        return {0x6041: self.status, 0x6064: self.position, 0x6061: 8}.get(index)

    def on_nmt(self, can_id, data, timestamp):
        command, target = data
        node = self.node
        if target not in (0, node.id):
            return
        if command in (0x81, 0x82):
            node.nmt.send_command(command)
            node.nmt.send_command(0x80)
        elif command == 0x01:
            # what was mapped over SDO
            node.tpdo.read(from_od=False)
            node.rpdo.read(from_od=False)
            if self.rpdo_cob is None:
                self.rpdo_cob = node.rpdo[1].cob_id
                self.network.subscribe(self.rpdo_cob, self.on_rpdo)

    def on_rpdo(self, can_id, data, timestamp):
        self.waiting = bytes(data)

    def on_sync(self, can_id, data, timestamp):
        if self.node.nmt.state != "OPERATIONAL":
            return
        self.syncs += 1
        if self.waiting is not None:
            # as our node maps it: controlword and target position
            word, target = struct.unpack("<Hi", self.waiting)
            self.waiting = None
            self.obey(word & 0x0F)
            if self.status == ENABLED:
                self.position = target
                self.positions.append(target)
        status = self.status | FOLLOWS if self.status == ENABLED else self.status
        tpdo = self.node.tpdo[1]
        answer = struct.pack("<Hih", status, self.position, 0)
        self.network.send_message(tpdo.cob_id, answer)

    def obey(self, command):
        if not command & 0x02:
            self.status = DISABLED
        elif command == 0x06:
            self.status = READY
        elif command == 0x07 and self.status in (READY, ENABLED):
            self.status = SWITCHED_ON
        elif command == 0x0F and self.status == SWITCHED_ON:
            self.status = ENABLED
        elif command == 0x02:
            self.status = DISABLED
