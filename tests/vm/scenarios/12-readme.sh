# The README's steps to a service, read from the installed text, but for building and installing, which the guest has behind
# it; and the manual's steps to a new key. The guest has no sudo: all is done as root or by runuser.
readme() { sed -n '/^## As a service/,/^## Where/s/^    //p' /usr/share/doc/dwell/README.md | tail -n +2; }
new_key() { sed -n 's/\\-/-/g; s/^sudo -u dwell \(.*--new-key.*\)$/runuser -u dwell -- \1/p' /usr/share/man/man8/dwelld.8*; }
key_of() { [ -s "$1/key.pub" ] && cat "$1/key.pub"; }
another_key() { [ "$(key_of "$1")" != "$2" ] || { echo "still $2"; return 1; }; }

start_rig --tcp 127.0.0.1:1502 --unit mm --noise 0.001
{ clamped_rig; printf '[recording]\n'; } >"$work/rig.toml"
readme | sed "s|sudo ||g; s|RIG.toml|$work/rig.toml|" >"$work/steps"
claim "readme: it tells four steps after the installation" test "$(wc -l <"$work/steps")" = 4
claim "readme: each of them succeeds" bash -ex "$work/steps"
claim "readme: the service answers" eventually 10 health '.status != null'
claim "readme: and comes with the next boot" systemctl is-enabled dwelld
systemctl disable dwelld 2>/dev/null

sed 's/^listen .*/listen = "127.0.0.1:8381"/' /etc/dwell/rig.toml >/etc/dwell/NAME.toml
systemctl start dwelld@NAME
claim "new key: the service has one" eventually 10 key_of /var/lib/dwell
claim "new key: and each instance has its own" eventually 10 key_of /var/lib/dwell/NAME
of_service=$(key_of /var/lib/dwell) of_instance=$(key_of /var/lib/dwell/NAME)
systemctl stop dwelld dwelld@NAME
new_key >"$work/steps"
claim "new key: the manual tells it for both" test "$(wc -l <"$work/steps")" = 2
claim "new key: it is made" bash -ex "$work/steps"
claim "new key: of the service" another_key /var/lib/dwell "$of_service"
claim "new key: of the instance" another_key /var/lib/dwell/NAME "$of_instance"
