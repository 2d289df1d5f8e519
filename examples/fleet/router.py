#!/usr/bin/env python3
"""The configuration of a router that is closed by default: mutual TLS, and a machine may speak under its own keys only.

    router.py FOLDER_OF_KEYS SITE MACHINE... > router.json5        LISTEN=tls/127.0.0.1:7447

`heft fleet router --zenoh-config router.json5` and `zenohd -c router.json5` both take it.
"""
import json, os, sys
if len(sys.argv) < 3:
    print("usage: router.py FOLDER_OF_KEYS SITE MACHINE...", file=sys.stderr)
    sys.exit(2)
folder, site, machines = sys.argv[1], sys.argv[2], sys.argv[3:]
rules, subjects, policies = [], [], []

def rule(name, flow, messages, *keys):
    # A chunk that begins with @ matches no wild card: the words between advanced publishers and subscribers.
    keys = [k for key in keys for k in (key, f"{key}/@adv/**")]
    rules.append(dict(id=name, permission="allow", flows=[flow], messages=messages, key_exprs=keys))
    return name

def subject(common_name, names):
    subjects.append(dict(id=common_name, cert_common_names=[common_name]))
    policies.append(dict(rules=names, subjects=[common_name]))

ask = ["declare_subscriber", "query", "declare_liveliness_subscriber", "liveliness_query"]
say = ["put", "reply", "declare_queryable", "liveliness_token"]
# A machine receives the wishes of subscribers, without which it sends nothing, but no data of others.
wishes = rule("wishes", "egress", ask, "heft/v1/**")
for machine in machines:
    subject(machine, [rule(f"only {machine}", "ingress", say, f"heft/v1/{site}/{machine}/**"), wishes])
subject("collector", [rule("collector asks", "ingress", ask, "heft/v1/**"), rule("collector hears", "egress", say, "heft/v1/**")])
# `heft fleet serve` receives the samples of all machines. It publishes its estimates beside those of the machines, and answers
# queries for them.
server = [rule("server asks", "ingress", ask, f"heft/v1/{site}/*/sample/**"), rule("server hears", "egress", say, f"heft/v1/{site}/*/sample/**"),
          rule("server says", "ingress", ["put", "reply", "declare_queryable"], f"heft/v1/{site}/*/site/*"), wishes]
subject("server", server)
print(json.dumps(dict(
    mode="router",
    listen=dict(endpoints=[os.environ.get("LISTEN", "tls/127.0.0.1:7447")]),
    scouting=dict(multicast=dict(enabled=False), gossip=dict(enabled=False)),
    adminspace=dict(enabled=False),
    transport=dict(
        unicast=dict(max_sessions=20000, accept_pending=1000),
        link=dict(protocols=["tls"], tls=dict(
            root_ca_certificate=f"{folder}/ca.pem", listen_private_key=f"{folder}/router.key", listen_certificate=f"{folder}/router.pem",
            enable_mtls=True, close_link_on_expiration=True))),
    access_control=dict(enabled=True, default_permission="deny", rules=rules, subjects=subjects, policies=policies),
), indent=1))
