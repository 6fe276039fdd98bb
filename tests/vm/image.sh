#!/usr/bin/env bash
# Makes the initramfs that is the whole guest out of what get.sh fetched; as root, in a second or two.
# usage: image.sh FOLDER KERNEL_VERSION IMAGE
set -euo pipefail
folder=$1 version=$2 image=$3
guest=$(dirname "$(readlink -f "$0")")/guest
stage=$(mktemp -d "$folder/stage.XXXXXX")
trap 'rm -rf "$stage"' EXIT

# The tree without what a test machine never uses.
tar -C "$folder/root" -cf - --one-file-system \
  --exclude=./usr/share/{doc,man,info,locale,perl,perl5,lintian,bash-completion,zsh,common-licenses,bug,gcc,polkit-1,i18n,zoneinfo} \
  --exclude=./usr/lib/x86_64-linux-gnu/{perl,perl5,libperl*,gconv} --exclude=./usr/lib/udev/hwdb.* \
  --exclude=./usr/lib/apt --exclude=./usr/lib/modules --exclude=./boot --exclude=./var/lib/apt --exclude=./var/cache \
  --exclude=./usr/lib/terminfo/[!lvdx]* . | tar -C "$stage" -xpf -
mkdir -p "$stage"/{proc,sys,dev,run,mnt/host,etc/systemd/journald.conf.d,etc/systemd/system/multi-user.target.wants}

# The modules it needs, with those that they need.
modules=$stage/usr/lib/modules/$version
mkdir -p "$modules/extra"
depmod -b "$folder/kernel" "$version"
for module in virtio_pci virtio_mmio virtio_console virtio_rng 9p 9pnet_virtio vcan vxcan can can_raw can_bcm can_gw \
  can_isotp can_j1939 configfs autofs4 unix af_packet loop dm_mod dm_log_writes dm_delay ext4 crc32c_generic crc32c_intel; do
  modprobe -d "$folder/kernel" -S "$version" --show-depends "$module" 2>/dev/null | awk '$1 == "insmod" {print $2}' || true
done | sort -u | while read -r file; do
  install -D -m644 "$file" "$modules/${file#*lib/modules/"$version"/}"
done
install -m644 "$folder/gpio-sim/gpio-sim.ko" "$modules/extra/"
cp "$folder/kernel/lib/modules/$version"/modules.{builtin,builtin.modinfo,order} "$modules/"
depmod -b "$stage" "$version"

# systemd is init; the last unit it starts runs what the host shares.
ln -sf /lib/systemd/systemd "$stage/init"
echo dwell-vm >"$stage/etc/hostname"
: >"$stage/etc/fstab"
echo 0123456789abcdef0123456789abcdef >"$stage/etc/machine-id"
touch "$stage/etc/.updated" "$stage/var/.updated"
printf 'can\ncan_raw\ncan_bcm\nvcan\nconfigfs\ngpio-sim\n' >"$stage/etc/modules-load.d/dwell-vm.conf"
printf '[Journal]\nStorage=volatile\nRateLimitBurst=0\n' >"$stage/etc/systemd/journald.conf.d/dwell-vm.conf"
install -m755 "$guest/dwell-vm" "$stage/usr/bin/dwell-vm"
install -m644 "$guest/dwell-vm.service" "$stage/etc/systemd/system/"
ln -sf ../dwell-vm.service "$stage/etc/systemd/system/multi-user.target.wants/"
ln -sf /lib/systemd/system/multi-user.target "$stage/etc/systemd/system/default.target"
# Every program costs tens of milliseconds to start here: what cannot matter is left out.
for unit in getty.target getty@tty1.service serial-getty@ttyS0.service console-getty.service apt-daily.timer \
  apt-daily-upgrade.timer dpkg-db-backup.timer e2scrub_all.timer e2scrub_reap.service fstrim.timer \
  systemd-update-utmp.service systemd-update-utmp-runlevel.service systemd-pstore.service \
  systemd-machine-id-commit.service systemd-random-seed.service systemd-boot-system-token.service \
  systemd-binfmt.service proc-sys-fs-binfmt_misc.automount systemd-remount-fs.service dev-hugepages.mount \
  dev-mqueue.mount sys-kernel-debug.mount sys-kernel-tracing.mount systemd-logind.service modprobe@dm_mod.service \
  modprobe@loop.service modprobe@efi_pstore.service modprobe@drm.service modprobe@fuse.service \
  sys-fs-fuse-connections.mount systemd-ask-password-console.path systemd-ask-password-wall.path \
  systemd-initctl.socket systemd-pcrphase.service systemd-pcrphase-sysinit.service; do
  ln -sf /dev/null "$stage/etc/systemd/system/$unit"
done
rm -f "$stage"/usr/lib/systemd/system-generators/systemd-{bless-boot,cryptsetup,gpt-auto,hibernate-resume,integritysetup,rc-local,run,system-update,sysv,veritysetup}-generator

(cd "$stage" && find . -print0 | cpio --null -o -H newc --quiet --reproducible) >"$image.part"
mv "$image.part" "$image"
