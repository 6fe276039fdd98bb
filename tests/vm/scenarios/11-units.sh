# What befalls the units: another instance is stopped, a hangup, an address that comes later than the service.
same_process() { [ "$(property MainPID)" = "$pid" ] || { property MainPID; return 1; }; }
answers_at() { dwellctl channels --url "$1"; }

start_rig --tcp 127.0.0.1:1502 --unit mm --noise 0.001
clamped_rig >"$work/rig.toml"
start_service <"$work/rig.toml"
sed 's/^listen .*/listen = "127.0.0.1:8381"/' "$work/rig.toml" >/etc/dwell/second.toml
systemctl start dwelld@second
claim "units: an instance has a control socket of its own" test -S /run/dwell/second/control
systemctl stop dwelld
claim "units: it stays when the service without a name is stopped" test -S /run/dwell/second/control
claim "units: and answers" dwellctl check --control /run/dwell/second/control
systemctl stop dwelld@second
claim "units: it goes with its own" test ! -e /run/dwell/second

start_service <"$work/rig.toml"
pid=$(property MainPID)
systemctl kill -s HUP dwelld
claim "units: a hangup is answered in the log" eventually 5 log_has "rig.toml is what is being served"
claim "units: and ends nothing" same_process

sed 's/^listen .*/listen = "192.0.2.7:8380"\nbehind_proxy = true/' "$work/rig.toml" | start_service
claim "units: an address that is not up yet does not keep the service from starting" \
  test "$(property ActiveState)" = active
claim "units: it is told" eventually 5 log_has "192.0.2.7:8380 is no address of this computer yet"
ip address add 192.0.2.7/32 dev lo
claim "units: and served once it is up" eventually 20 answers_at http://192.0.2.7:8380
ip address del 192.0.2.7/32 dev lo
