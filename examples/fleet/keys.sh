#!/usr/bin/env bash
# Keys for a fleet with mutual TLS: an authority, a router, a collector, a server (`heft fleet serve`), machines; and the
# configuration of each.
#
#   keys.sh FOLDER SITE MACHINE...     DAYS=365 ROUTER=localhost AT=FOLDER
#
# The configurations name their files by absolute paths: AT is the folder in which each host will have them.
# A machine's name is its certificate's common name: the router lets it write its own keys only. Run it again in
# the same folder to add machines; give each host its own three files and ca.pem, and keep ca.key to yourself.
set -euo pipefail
umask 077
if [ $# -lt 2 ]; then
  echo "keys.sh: keys.sh FOLDER SITE MACHINE..., with DAYS=365, ROUTER=localhost (the router's name), LISTEN=tls/ADDRESS:PORT, AT=FOLDER (where each host will have its files)" >&2; exit 2
fi
folder=$1 site=$2; shift 2
case ${AT:-/} in /*) ;; *) echo "keys.sh: AT=$AT: write the whole path, such as AT=/etc/heft/keys" >&2; exit 2 ;; esac
# A name stands in keys of Zenoh, in files and in certificates: letters, digits, and . _ - inside; never one that has another meaning here.
for name in "$site" "$@"; do
  if [[ ! $name =~ ^[A-Za-z0-9]([A-Za-z0-9._-]{0,62}[A-Za-z0-9])?$ ]]; then
    echo "keys.sh: \`$name\` cannot name a site or a machine: 1 to 64 letters, digits, dots, hyphens and underscores, a letter or digit at both ends" >&2; exit 2
  fi
done
for name in "$@"; do
  case $name in ca|router|collector|server) echo "keys.sh: \`$name\` is a name of the fleet itself; call the machine otherwise" >&2; exit 2 ;; esac
done
days=${DAYS:-365} router=${ROUTER:-localhost} here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$folder"; cd "$folder"
at=${AT:-$PWD}
if [ -e site ] && [ "$(cat site)" != "$site" ]; then
  echo "keys.sh: this folder is of the site $(cat site): its router lets machines of one site in; take a folder for each site" >&2; exit 2
fi
echo "$site" > site
key() { openssl ecparam -name prime256v1 -genkey -noout -out "$1.key"; }
if [ ! -e ca.pem ]; then
  key ca
  openssl req -x509 -new -key ca.key -days 3650 -subj "/CN=heft fleet authority" -out ca.pem
fi
certificate() { # NAME ADDRESSES
  [ -e "$1.pem" ] && return
  key "$1"
  openssl req -new -key "$1.key" -subj "/CN=$1" -out "$1.csr"
  printf 'subjectAltName=%s\nbasicConstraints=CA:FALSE\nkeyUsage=digitalSignature\nextendedKeyUsage=serverAuth,clientAuth' "$2" > "$1.ext"
  # It talks where all is well; a certificate that is there is a whole one.
  if ! said=$(openssl x509 -req -in "$1.csr" -CA ca.pem -CAkey ca.key -CAcreateserial -days "$days" -out "$1.new" -extfile "$1.ext" 2>&1); then
    printf 'keys.sh: no certificate for %s: %s\n' "$1" "$said" >&2; exit 1
  fi
  rm "$1.csr" "$1.ext"
  cat > "$1.json5" <<END
{ transport: { link: { tls: {
  root_ca_certificate: "$at/ca.pem", connect_private_key: "$at/$1.key", connect_certificate: "$at/$1.pem",
  enable_mtls: true, close_link_on_expiration: true } } } }
END
  mv "$1.new" "$1.pem"
}
certificate router "DNS:$router,DNS:localhost,IP:127.0.0.1"
certificate collector "DNS:collector"
certificate server "DNS:server"
for machine in "$@"; do certificate "$machine" "DNS:$machine"; done
machines=$(ls *.pem | sed 's/\.pem$//' | grep -vxE 'ca|router|collector|server')
python3 "$here/router.py" "$at" "$site" $machines > router.json5
echo "router.json5 and one configuration for each of: collector server" $machines
