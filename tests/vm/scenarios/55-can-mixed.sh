# One dwell on two devices: the table and the first two masses over Modbus, the last mass and the load cell on CAN.
mixed_rig() {
  clamped_rig | awk '/^\[\[channel\]\]/ {n++} n <= 3'
  can_rig vcan0 | awk '/^\[\[device\]\]/ {on = 1} /^\[\[channel\]\]/ {n++; on = n > 3} on'
}

start_can vcan0
start_rig --tcp 127.0.0.1:1502 --unit mm --can vcan0 --can-rate 80 --noise 0.001
mixed_rig | start_service
claim "mixed: both devices are up" eventually 30 health '[.devices[] | select(.up) | .driver] | sort == ["can", "modbus"]'
claim "mixed: every coefficient is within 4 u of the truth" every_coefficient_is_right 20 150
