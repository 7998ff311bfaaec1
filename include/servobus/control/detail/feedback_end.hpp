// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The end of a read of the feedback, or of the witness. Feedback that raises a suspicion is held back until the witness
// is read. Then the model has it, and the steps of the routine. A step may end its command here; nothing begins or
// replaces one.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/control/detail/command_slot.hpp>
#include <servobus/control/detail/knowledge.hpp>
#include <servobus/control/detail/terms.hpp>
#include <servobus/control/detail/verdict_rules.hpp>
#include <servobus/control/drive_model.hpp>
#include <servobus/control/states.hpp>
#include <servobus/core/bytes.hpp>

namespace servobus::detail {

/// As `may_ask_witness`, in a single copy: for a drive whose `witness` takes much code.
template <class Model>
[[gnu::noinline]] constexpr bool may_ask_other_witness(const knowledge<Model>& known,
                                                       const command_slot<Model>& slot) {
    return known.is_known() && known.witness(slot.command()).look != nullptr;
}
/// The witness can be read: the settings are known, and the drive has one in this state.
template <class Model>
constexpr bool may_ask_witness(const knowledge<Model>& known, const command_slot<Model>& slot) {
    if constexpr (polling<Model>::has_watchdog) // one that takes little code
        return known.is_known() && known.witness(slot.command()).look != nullptr;
    else
        return may_ask_other_witness(known, slot);
}

/// Judges an image that was read. True if it is to be held back until the witness is read. `is_verified`: it was, and
/// the witness is unchanged.
template <class Model>
[[gnu::always_inline]] constexpr bool is_held_back(knowledge<Model>& known, const command_slot<Model>& slot,
                                                   const std::uint16_t* words, bool is_verified,
                                                   verdict& found) {
    const bool is_fall = !is_verified && known.has_fallen(words);
    found = judged(known, slot, words);
    if (is_fall && found != verdict::disabled) found = verdict::uncertain;
    if (found != verdict::uncertain) return false;
    if (!is_verified && may_ask_witness(known, slot)) return true;
    if (is_fall) known.feedback().note_origin();
    if (is_verified || is_fall) found = verdict::as_expected; // a restart shows nowhere else
    return false;
}

/// The step under way asks the model, by the image.
template <class Model>
[[gnu::noinline]] constexpr void ask_model(knowledge<Model>& known, command_slot<Model>& slot, instant now) {
    routine_run& run = slot.run();
    // A motion counts from its start, which may have been another command's.
    const duration waited = slot.kind() == command_kind::power ? known.feedback().until_image(run.entered())
                                                               : known.since_start();
    const situation seen{.image = known.feedback().image(), .words = run.words(), .waited = waited};
    errc found = errc::ok;
    if (run.current().what == step::kind::permit) {
        found = known.model().permit(slot.command(), seen, known.cached());
        if (slot.command().steps.empty()) return run.finish(); // nothing is left to do
    } else {
        found = known.model().confirm(slot.command(), seen, known.cached());
    }
    run.conclude_question(found, now);
}

/// Uses the image that was taken: for the model, what was held back, and the steps of the routine.
template <class Model>
constexpr void use_image(knowledge<Model>& known, command_slot<Model>& slot, const std::uint8_t* held,
                         instant now) {
    // Positions may be counted from elsewhere after the next refresh too.
    known.note_image(slot.is_setting_origin() || slot.is_stopping());
    known.take_held_block(held);
    slot.run().use_image(known.feedback().image(), image_block<Model>, now);
    if (slot.run().asks_model()) ask_model(known, slot, now);
}

/// A read of a slower block has ended.
template <class Model, class Exchange>
constexpr void conclude_slower(knowledge<Model>& known, command_slot<Model>& slot, Exchange& x,
                               std::uint8_t* held, const terms& by, const status& got, instant began,
                               instant now) {
    auto& slower = known.polling().slower();
    const std::uint8_t block = slower.block();
    const bool is_read_by_step = slower.block_for(slot.run()) == block;
    slower.land();
    if (is_read_by_step) known.set_last_frame(last_frame::step_read);
    if (got.error() != errc::ok) {
        if (is_read_by_step) slot.run().fail_read(got, by);
        return;
    }
    std::uint16_t words[steps::longest]; // NOLINT: as many as the block has are filled
    for (std::size_t i = 0; i < Model::blocks[block].words; ++i) words[i] = x.words()[i];
    if (known.withholds(block, words, began, may_ask_witness(known, slot))) {
        known.feedback().held().hold_block(held, x.response());
        slower.note_held(began);
    } else {
        known.take_block(block, words, began);
    }
    slot.run().use_image(words, Model::blocks[block], now);
}

/// A read of the feedback has ended. True if it has given an image.
template <class Model, class Exchange>
[[gnu::always_inline]] constexpr bool take_read(knowledge<Model>& known, command_slot<Model>& slot,
                                                Exchange& x, std::uint8_t* held, const terms& by,
                                                instant began, instant now) {
    known.set_last_frame(last_frame::feedback);
    if constexpr (polling<Model>::has_slower) {
        if (known.polling().slower().is_in_flight()) {
            conclude_slower(known, slot, x, held, by, x.status(), began, now);
            return false;
        }
    }
    if (x.status().error() == errc::ok) {
        known.polling().note_refresh(began);
        return true;
    }
    known.feedback().held().drop();
    known.polling().postpone(now);
    if (slot.run().reads(image_block<Model>)) slot.run().fail_read(x.status(), by);
    return false;
}
/// The read of the witness has ended. False if there is nothing to compare: no response, or the settings are not known
/// any more.
template <class Model>
constexpr bool take_witness(knowledge<Model>& known, command_slot<Model>& slot, const terms& by,
                            const status& got, instant now) {
    known.set_last_frame(last_frame::witness);
    known.link().end_check();
    if (got.error() != errc::ok) {
        known.feedback().held().drop();
        known.polling().postpone(now); // a drive that does not respond is not read in every step
        if (!slot.is_idle()) slot.run().fail_read(got, by);
        return false;
    }
    if (!known.is_known() && slot.run().awaits_witness()) // invalidated meanwhile
        slot.run().end(errc::needs_init, false);
    return known.is_known();
}
} // namespace servobus::detail
