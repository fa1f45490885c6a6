"""Opens logs with readers that know nothing of bksim, and prints what they found as JSON.

    judge.py contents LOG...     what the published channels hold
    judge.py schemas LOG...      the schemas against those that Foxglove has published
    judge.py slider-crank LOG    the transforms against the crank's triangle
    judge.py rerun LOG...        what Rerun's own loader makes of it
    judge.py digest LOG...       every message of the published channels, as one number each channel
"""

import collections
import hashlib
import importlib
import json
import math
import sys

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory


def messages(path):
    """Topic, log time in ns and decoded message of every message, in the order of time."""
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()], validate_crcs=True)
        for _, channel, raw, message in reader.iter_decoded_messages():
            yield channel.topic, raw.log_time, message


def by_topic(path):
    topics = collections.defaultdict(list)
    for topic, log_time, message in messages(path):
        topics[topic].append((log_time, message))
    return topics


def nanoseconds(stamp):
    return stamp.seconds * 10**9 + stamp.nanos


def quaternion(transform):
    r = transform.rotation
    return r.x, r.y, r.z, r.w


def check_transforms(topic, frames):
    """Unit quaternions that never take the long way, times as logged, the same frames each time."""
    previous = {}
    for log_time, message in topic:
        assert [t.child_frame_id for t in message.transforms] == frames
        for transform in message.transforms:
            assert nanoseconds(transform.timestamp) == log_time
            q = quaternion(transform)
            norm = math.hypot(*q)
            assert abs(norm - 1) < 1e-14, norm
            last = previous.get(transform.child_frame_id, q)
            assert sum(a * b for a, b in zip(q, last)) > 0, (log_time, transform.child_frame_id)
            previous[transform.child_frame_id] = q


def check_joints(topics):
    """Joint states are the numbers of the log's own channels, bit for bit."""
    own = zip(topics["/state"], topics["/acceleration"], topics["/joint_states"], strict=True)
    for (t, state), (_, acceleration), (log_time, message) in own:
        assert t == log_time == nanoseconds(message.timestamp)
        for joint in message.joints:
            assert joint.position == getattr(state, joint.name)
            assert joint.velocity == getattr(state, joint.name + "_dot")
            assert joint.acceleration == getattr(acceleration, joint.name + "_ddot")


def area(triangles):
    """Area of a list of triangles."""
    def corner(index):
        p = triangles.points[index]
        return p.x, p.y, p.z

    total = 0.0
    for i in range(0, len(triangles.indices), 3):
        a, b, c = (corner(index) for index in triangles.indices[i : i + 3])
        u, v = [[p[k] - a[k] for k in range(3)] for p in (b, c)]
        normal = [u[k - 2] * v[k - 1] - u[k - 1] * v[k - 2] for k in range(3)]
        total += 0.5 * math.hypot(*normal)
    return total


def entity(e):
    return {
        "id": e.id,
        "frame": e.frame_id,
        "is_locked": e.frame_locked,
        "is_for_ever": nanoseconds(e.lifetime) == 0,
        "areas": [area(t) for t in e.triangles],
        "lines": [len(line.points) for line in e.lines],
        "heights": [t.points[0].z for t in e.triangles],
    }


def contents(path):
    topics = by_topic(path)
    tf = topics["/tf"]
    frames = [t.child_frame_id for t in tf[0][1].transforms]
    check_transforms(tf, frames)
    check_joints(topics)
    roots = {t.parent_frame_id for _, message in tf for t in message.transforms}
    efforts = [(j.name, j.HasField("effort")) for j in topics["/joint_states"][0][1].joints]
    return {
        "messages": {topic: len(all) for topic, all in topics.items()},
        "roots": sorted(roots),
        "frames": frames,
        "scene_times": [log_time for log_time, _ in topics["/scene"]],
        "entities": [entity(e) for _, update in topics["/scene"] for e in update.entities],
        "joints": efforts,
        "log": [[t, nanoseconds(m.timestamp), m.level, m.message] for t, m in topics["/log"]],
    }


def described(file):
    """Messages and enumerations of a file: what each field is called, numbered and made of."""
    found = {}

    def message(prefix, m):
        name = f"{prefix}.{m.name}"
        found[name] = [
            (f.name, f.number, f.type, f.label, f.type_name, f.oneof_index if f.HasField("oneof_index") else None)
            for f in m.field
        ]
        for nested in m.nested_type:
            message(name, nested)
        for e in m.enum_type:
            enumeration(name, e)

    def enumeration(prefix, e):
        found[f"{prefix}.{e.name}"] = [(v.name, v.number) for v in e.value]

    for m in file.message_type:
        message(file.package, m)
    for e in file.enum_type:
        enumeration(file.package, e)
    return found


def schemas(path):
    """Every schema that is not bksim's own, compared in full; what was compared, by name."""
    from google.protobuf import duration_pb2, timestamp_pb2
    from google.protobuf.descriptor_pb2 import FileDescriptorProto, FileDescriptorSet

    with open(path, "rb") as file:
        known = make_reader(file).get_summary().schemas.values()
    counts = {}
    for schema in known:
        if schema.name.startswith("bksim."):
            continue
        assert schema.encoding == "protobuf"
        n_fields = 0
        for file in FileDescriptorSet.FromString(schema.data).file:
            if file.package == "google.protobuf":
                pb2 = {"timestamp": timestamp_pb2, "duration": duration_pb2}[file.name.split("/")[-1][:-6]]
            else:
                name = file.name.split("/")[-1].removesuffix(".proto")
                pb2 = importlib.import_module(f"foxglove_schemas_protobuf.{name}_pb2")
            published = FileDescriptorProto.FromString(pb2.DESCRIPTOR.serialized_pb)
            ours, theirs = described(file), described(published)
            assert ours == theirs, f"{schema.name}: {file.name}: {ours} is not {theirs}"
            n_fields += sum(len(fields) for fields in ours.values())
        counts[schema.name] = n_fields
    return counts


def slider_crank(path):
    """Worst error, m and rad, of the transforms against those that the crank's angle gives."""
    with open(path, "rb") as file:
        records = make_reader(file).iter_metadata()
        texts = next(r.metadata for r in records if r.name == "bksim.parameters")
    l1, s2 = (float(texts[name].split()[0]) for name in ("l1", "s2"))
    topics = by_topic(path)
    places, angles, n_compared = 0.0, 0.0, 0
    for (_, state), (_, message) in zip(topics["/state"], topics["/tf"], strict=True):
        theta = state.theta1
        pin = l1 * math.cos(theta), l1 * math.sin(theta)
        # The slider's pin lies on the x axis, a rod of 2 s2 away; the rod's frame is in its middle.
        slider = pin[0] + math.sqrt((2 * s2) ** 2 - pin[1] ** 2)
        expected = {
            "crank": (0.0, 0.0, theta),
            "rod": ((pin[0] + slider) / 2, pin[1] / 2, math.atan2(-pin[1], slider - pin[0])),
            "slider": (slider, 0.0, 0.0),
        }
        for transform in message.transforms:
            x, y, angle = expected[transform.child_frame_id]
            p, (qx, qy, qz, qw) = transform.translation, quaternion(transform)
            assert (p.z, qx, qy) == (0, 0, 0)
            turned = math.remainder(2 * math.atan2(qz, qw) - angle, 2 * math.pi)
            places = max(places, math.hypot(p.x - x, p.y - y))
            angles = max(angles, abs(turned))
            n_compared += 1
    return {"places": places, "angles": angles, "n_compared": n_compared}


def rerun(path):
    """Rows of each entity by the archetypes that Rerun has made of them."""
    from rerun.chunk import McapReader

    entities = collections.defaultdict(collections.Counter)
    for chunk in McapReader(path).stream().to_chunks():
        columns = chunk.to_record_batch().schema.names
        for archetype in {c.split(":")[0].split(".")[-1] for c in columns if ":" in c}:
            entities[chunk.entity_path][archetype] += chunk.num_rows
    return entities


def digest(path):
    digests = collections.defaultdict(hashlib.sha256)
    with open(path, "rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            if schema.name.startswith("foxglove."):
                times = message.log_time, message.publish_time, message.sequence, len(message.data)
                digests[channel.topic].update(repr(times).encode() + message.data)
    return {topic: digest.hexdigest() for topic, digest in digests.items()}


TASKS = {
    "contents": contents,
    "schemas": schemas,
    "slider-crank": slider_crank,
    "rerun": rerun,
    "digest": digest,
}

if __name__ == "__main__":
    task, *paths = sys.argv[1:]
    print(json.dumps([TASKS[task](path) for path in paths]))
