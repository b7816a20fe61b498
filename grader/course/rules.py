"""What a course may decide otherwise."""

# Share of an exercise that an answer keeps which is proven to be one edit away from a right one, if
# its checks earn less. With 0 nobody looks for such an edit.
ONE_SLIP_KEEPS = 0.6
