# Answers lost and late, and a node that babbles, during a dwell: counted, and never taken for another SYNC's.
start_can vcan0
start_rig --canopen vcan0 --noise 0.001
canopen_rig vcan0 | start_service
claim "canopen losses: a dwell is measured" eventually 60 dwell_is '.state == "measuring"'
rig_says missing 0.02
rig_says late-by 0.03
rig_says late 0.02
rig_says babble 300
claim "canopen losses: late answers are counted" eventually 20 faults_reach "late answer" 5
claim "canopen losses: with answers lost and late and a node that babbles, every coefficient is within 4 u" every_coefficient_is_right 20 200
