# A complete dwell over Modbus TCP, each coefficient against the simulated rig's truth; the one dwell of the guest that is
# verified as it is measured.
start_rig --tcp 127.0.0.1:1502 --unit mm --noise 0.001
clamped_rig | sed '/^live = false/d' | start_service
claim "modbus: every coefficient is within 4 u of the truth" every_coefficient_is_right 20 150
