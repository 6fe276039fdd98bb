#!/usr/bin/env bash
# Fetches and builds what the guest is made of, from the system's own package sources, into FOLDER; as root.
#   root/      a Debian tree with systemd, udev, can-utils and gpiod; no library of ours needs to be named here: run
#              carries along what the programs under test link
#   kernel/    the distribution's kernel, unpacked, never installed here; vmlinux, so that the guest need not unpack it
#   gpio-sim/  the simulated GPIO chips: the distribution's kernels leave that module out, so it is built from their source
# usage: get.sh FOLDER KERNEL_VERSION
set -euo pipefail
folder=$1 version=$2
packages=usr-is-merged,systemd,systemd-sysv,dbus,udev,kmod,procps,iproute2,can-utils,gpiod,dmsetup,gojq,init-system-helpers,adduser
release=$(. /etc/os-release && echo "$VERSION_CODENAME")
here=$(dirname "$(readlink -f "$0")")
rm -rf "$folder"
mkdir -p "$folder/kernel" "$folder/gpio-sim" "$folder/source"
cd "$folder"

# apt's own configuration is handed over as it is: no mirror is named here.
mapfile -t sources < <(grep -lE "^(Suites:|deb ).*[[:space:]]$release(-updates|-security)?([[:space:]]|\$)" /etc/apt/sources.list /etc/apt/sources.list.d/*.sources \
  /etc/apt/sources.list.d/*.list 2>/dev/null)
mmdebstrap --quiet --mode=root --variant=minbase --include=$packages --aptopt='APT::Install-Recommends "false"' \
  --dpkgopt='path-exclude=/usr/share/doc/*' --dpkgopt='path-exclude=/usr/share/man/*' \
  --dpkgopt='path-exclude=/usr/share/locale/*' --hook-dir=/usr/share/mmdebstrap/hooks/merged-usr \
  "$release" root "${sources[@]}"

package_version=$(apt-cache policy "linux-image-$version" | awk '$1 == "Candidate:" {print $2}')
apt-get -qq download "linux-image-$version=$package_version" "linux-source-${version%.0-*}=$package_version"
dpkg-deb -x linux-image-*.deb kernel
python3 "$here/extract-vmlinux.py" "kernel/boot/vmlinuz-$version" vmlinux
dpkg-deb -x linux-source-*.deb source
tar -xJf source/usr/src/linux-source-*.tar.xz -C gpio-sim --strip-components=1 --wildcards \
  '*/drivers/gpio/gpio-sim.c' '*/drivers/gpio/gpiolib.h' '*/kernel/irq/irq_sim.c'
rm -rf source ./*.deb

cd gpio-sim
mv drivers/gpio/gpio-sim.c gpio-sim-core.c
mv drivers/gpio/gpiolib.h kernel/irq/irq_sim.c .
rm -r drivers kernel
# irq_to_desc() is not exported to modules; generic_handle_irq() does the same for this flow.
sed -i 's/handle_simple_irq(irq_to_desc(irqnum));/generic_handle_irq(irqnum);/' irq_sim.c
grep -q 'generic_handle_irq(irqnum);' irq_sim.c
# A chip that is removed keeps its interrupts. This kernel frees them under whoever holds a line, and corrupts its memory
# when the line is let go: what is tested there is the service, not that.
sed -i 's/devm_irq_domain_create_sim(dev, swnode,/irq_domain_create_sim(swnode,/;
  s/irq_dispose_mapping(irq_find_mapping(chip->irq_sim, i));/irq_find_mapping(chip->irq_sim, i);/' gpio-sim-core.c
grep -q ' irq_domain_create_sim(swnode,' gpio-sim-core.c
grep -q '^\s*irq_find_mapping(chip->irq_sim, i);' gpio-sim-core.c
printf 'obj-m := gpio-sim.o\ngpio-sim-y := gpio-sim-core.o irq_sim.o\n' >Makefile
make -s -C "/lib/modules/$version/build" M="$PWD" modules
strip --strip-debug gpio-sim.ko
