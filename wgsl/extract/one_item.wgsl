// Invocations that take one face or edge record of a single mesh each.

fn take_items(invocation: u32) {
  if (invocation < chunk.count) {
    take_item(invocation, invocation);
  }
}
