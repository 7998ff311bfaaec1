// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A plain model of a server of rows, written from the standard and apart from the library: it has its own storage, its
// own parsing and its own list of the device's rows (Modbus Application Protocol V1.1b3, section 6). With it requests
// that reach every corner of a device.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace row_model {

using byte_list = std::vector<std::uint8_t>;

/// A row: c coil, d discrete input, h holding register, i input register.
struct row {
    char table;
    unsigned address;
    unsigned words;
    std::string rights; ///< of r and w
    long long low, high, initial;
};

struct device {
    std::vector<row> rows;
    bool is_low_first = false;
    unsigned most_read = 125, most_written = 123;
    std::size_t room = 253; ///< of the server's buffer
    std::string functions;  ///< m 16h, w 17h, l Return Query Data
    std::vector<std::pair<unsigned, std::string>> objects;
    std::string id;
};

inline unsigned word(const byte_list& b, std::size_t at) { return b.at(at) * 256u + b.at(at + 1); }
inline std::uint8_t low_byte(unsigned long long v) { return static_cast<std::uint8_t>(v % 256); }

class model {
  public:
    /// The description must outlive it.
    explicit model(const device& of) : device_{of} {
        for (const row& r : of.rows) values_.push_back(r.initial);
    }

    long long& value(char table, unsigned address) { return values_.at(at(table, address)); }
    const device& description() const { return device_; }

    /// Nothing for what is no request.
    byte_list respond(const byte_list& pdu) {
        if (pdu.empty() || pdu[0] > 127) return {};
        byte_list response;
        const unsigned wrong = execute(pdu, response);
        if (wrong != 0) return {low_byte(pdu[0] + 128u), low_byte(wrong)};
        return response;
    }

  private:
    bool has(char table, char right) const {
        return std::any_of(device_.rows.begin(), device_.rows.end(), [&](const row& r) {
            return r.table == table && r.rights.find(right) != std::string::npos;
        });
    }
    bool offers(char function) const { return device_.functions.find(function) != std::string::npos; }

    bool is_served(unsigned code) const {
        switch (code) {
        case 1: return has('c', 'r');
        case 2: return has('d', 'r');
        case 3: return has('h', 'r');
        case 4: return has('i', 'r');
        case 5:
        case 15: return has('c', 'w');
        case 6:
        case 16: return has('h', 'w');
        case 8: return offers('l');
        case 17: return !device_.id.empty();
        case 22: return offers('m') && has('h', 'w');
        case 23: return offers('w') && has('h', 'w') && has('h', 'r');
        case 43: return !device_.objects.empty();
        default: return false;
        }
    }

    unsigned execute(const byte_list& pdu, byte_list& out) {
        const unsigned code = pdu[0];
        const std::size_t size = pdu.size();
        if (!is_served(code)) return 1;
        if (code < 5) {
            if (size != 5) return 3;
            return read(" cdhi"[code], word(pdu, 1), word(pdu, 3), code < 3 ? 2000 : device_.most_read, code,
                        out);
        }
        switch (code) {
        case 5: {
            if (size != 5 || (word(pdu, 3) != 0 && word(pdu, 3) != 0xFF00)) return 3;
            out = pdu;
            return write('c', word(pdu, 1), {word(pdu, 3) == 0 ? 0u : 1u});
        }
        case 6:
            if (size != 5) return 3;
            out = pdu;
            return write('h', word(pdu, 1), {word(pdu, 3)});
        case 8:
            if (size >= 3 && word(pdu, 1) != 0) return 1;
            if (size < 5 || size % 2 == 0 || size > device_.room) return 3;
            out = pdu;
            return 0;
        case 15: {
            if (size < 6 || pdu[5] != size - 6) return 3;
            const unsigned count = word(pdu, 3);
            if (count < 1 || count > 1968 || (count + 7) / 8 != pdu[5]) return 3;
            std::vector<unsigned> bits;
            for (unsigned i = 0; i < count; ++i) bits.push_back(unsigned{pdu[6 + i / 8]} >> i % 8 & 1u);
            out = {pdu.begin(), pdu.begin() + 5};
            return write('c', word(pdu, 1), bits);
        }
        case 16: {
            if (size < 6 || pdu[5] != size - 6) return 3;
            const unsigned count = word(pdu, 3);
            if (count < 1 || count > device_.most_written || 2 * count != pdu[5]) return 3;
            out = {pdu.begin(), pdu.begin() + 5};
            return write('h', word(pdu, 1), words(pdu, 6));
        }
        case 17: {
            if (size != 1) return 3;
            out = {17, low_byte(device_.id.size() + 1)};
            out.insert(out.end(), device_.id.begin(), device_.id.end());
            out.push_back(0xFF);
            return 0;
        }
        case 22: {
            if (size != 7) return 3;
            const auto found = find('h', word(pdu, 1), 1, 'r');
            if (!found) return 2;
            const auto now = static_cast<unsigned>(value('h', word(pdu, 1)) & 0xFFFF);
            out = pdu;
            return write('h', word(pdu, 1), {(now & word(pdu, 3)) | (word(pdu, 5) & ~word(pdu, 3) & 0xFFFF)});
        }
        case 23: return write_then_read(pdu, out);
        default: return identify(pdu, out);
        }
    }

    static std::vector<unsigned> words(const byte_list& pdu, std::size_t from) {
        std::vector<unsigned> all;
        for (std::size_t at = from; at < pdu.size(); at += 2) all.push_back(word(pdu, at));
        return all;
    }

    // The rows that cover exactly these addresses and have the right.
    std::optional<std::vector<const row*>> find(char table, unsigned address, unsigned count,
                                                char right) const {
        std::vector<const row*> found;
        for (unsigned at = address; at < address + count;) {
            const auto r = std::find_if(device_.rows.begin(), device_.rows.end(),
                                        [&](const row& x) { return x.table == table && x.address == at; });
            if (r == device_.rows.end() || r->rights.find(right) == std::string::npos) return std::nullopt;
            at += r->words;
            if (at > address + count) return std::nullopt;
            found.push_back(&*r);
        }
        return found;
    }

    unsigned read(char table, unsigned address, unsigned count, unsigned most, unsigned code,
                  byte_list& out) {
        if (count < 1 || count > most) return 3;
        const auto found = find(table, address, count, 'r');
        if (!found) return 2;
        out = {low_byte(code)};
        if (table == 'c' || table == 'd') {
            out.push_back(low_byte((count + 7) / 8));
            out.resize(2 + (count + 7) / 8);
            for (unsigned i = 0; i < count; ++i) {
                if (value(table, address + i) != 0) out[2 + i / 8] |= low_byte(1u << i % 8);
            }
            return 0;
        }
        out.push_back(low_byte(2 * count));
        for (const row* r : *found) {
            const auto v = static_cast<unsigned long long>(value(r->table, r->address));
            for (unsigned w = 0; w < r->words; ++w) {
                const unsigned shift = 16 * (device_.is_low_first ? w : r->words - 1 - w);
                out.push_back(low_byte(v >> shift >> 8));
                out.push_back(low_byte(v >> shift));
            }
        }
        return 0;
    }

    unsigned write(char table, unsigned address, const std::vector<unsigned>& data) {
        const auto found = find(table, address, static_cast<unsigned>(data.size()), 'w');
        if (!found) return 2;
        std::vector<long long> wanted;
        std::size_t at = 0;
        for (const row* r : *found) {
            long long v = data[at];
            if (r->words == 2) {
                v = device_.is_low_first ? data[at + 1] * 65536LL + data[at]
                                         : data[at] * 65536LL + data[at + 1];
            }
            at += r->words;
            const long long modulus = r->words == 2 ? 1LL << 32 : 1LL << 16;
            if (r->low < 0 && v >= modulus / 2) v -= modulus;
            wanted.push_back(v);
        }
        for (std::size_t i = 0; i < wanted.size(); ++i) {
            if (table == 'h' && (wanted[i] < (*found)[i]->low || wanted[i] > (*found)[i]->high)) return 3;
        }
        for (std::size_t i = 0; i < wanted.size(); ++i) value(table, (*found)[i]->address) = wanted[i];
        return 0;
    }

    unsigned write_then_read(const byte_list& pdu, byte_list& out) {
        if (pdu.size() < 10 || pdu[9] != pdu.size() - 10) return 3;
        const unsigned from = word(pdu, 1), count = word(pdu, 3), to = word(pdu, 5), written = word(pdu, 7);
        if (count < 1 || count > device_.most_read || written < 1 ||
            written > std::min(121u, device_.most_written) || 2 * written != pdu[9])
            return 3;
        if (!find('h', from, count, 'r')) return 2;
        const unsigned wrong = write('h', to, words(pdu, 10));
        return wrong != 0 ? wrong : read('h', from, count, count, 23, out);
    }

    unsigned identify(const byte_list& pdu, byte_list& out) const {
        if (pdu.size() > 1 && pdu[1] != 14) return 1;
        if (pdu.size() != 4 || pdu[2] < 1 || pdu[2] > 4) return 3;
        std::vector<std::pair<unsigned, std::string>> asked;
        for (const auto& o : device_.objects) {
            const bool is_of_kind = pdu[2] == 4   ? o.first == pdu[3]
                                    : pdu[2] == 1 ? o.first < 3
                                                  : pdu[2] == 3 || o.first < 128;
            if (is_of_kind) asked.push_back(o);
        }
        if (asked.empty()) return 2;
        auto next =
            std::find_if(asked.begin(), asked.end(), [&](const auto& o) { return o.first == pdu[3]; });
        if (next == asked.end()) next = asked.begin();
        const unsigned last = device_.objects.back().first;
        out = {43, 14, pdu[2], low_byte(0x81u + (last > 2) + (last > 127)), 0, 0, 0};
        for (; next != asked.end(); ++next) {
            if (out.size() + 2 + next->second.size() > device_.room) {
                out[4] = 0xFF;
                out[5] = low_byte(next->first);
                break;
            }
            ++out[6];
            out.push_back(low_byte(next->first));
            out.push_back(low_byte(next->second.size()));
            out.insert(out.end(), next->second.begin(), next->second.end());
        }
        return 0;
    }

    std::size_t at(char table, unsigned address) const {
        const auto r = std::find_if(device_.rows.begin(), device_.rows.end(),
                                    [&](const row& x) { return x.table == table && x.address == address; });
        return static_cast<std::size_t>(r - device_.rows.begin());
    }

    const device& device_;
    std::vector<long long> values_; // in the order of the rows
};

/// Random numbers by SplitMix64: little state, since a fuzzer makes many.
struct dice {
    std::uint64_t state;

    std::uint32_t operator()() {
        std::uint64_t z = state += 0x9E37'79B9'7F4A'7C15;
        z = (z ^ z >> 30) * 0xBF58'476D'1CE4'E5B9;
        z = (z ^ z >> 27) * 0x94D0'49BB'1331'11EB;
        return static_cast<std::uint32_t>((z ^ z >> 31) >> 32);
    }
};

/// Requests for a device: most are well-formed and near its rows, some have a byte changed, lost or added.
class maker {
  public:
    maker(const device& of, unsigned seed) : device_{&of}, engine_{seed} {}

    unsigned below(unsigned end) { return static_cast<unsigned>(engine_() % end); }
    bool one_in(unsigned count) { return below(count) == 0; }

    byte_list request() {
        static constexpr unsigned codes[]{1,  2,  3,  3,  4,  5,  6, 6,  15, 16,
                                          16, 16, 22, 22, 23, 23, 8, 17, 43, 43};
        byte_list pdu{low_byte(one_in(40) ? below(256) : codes[below(std::size(codes))])};
        fill(pdu);
        if (one_in(10)) pdu[below(static_cast<unsigned>(pdu.size()))] ^= low_byte(1u << below(8));
        if (one_in(20)) pdu.resize(1 + below(static_cast<unsigned>(pdu.size())));
        if (one_in(20)) pdu.push_back(low_byte(below(256)));
        if (pdu.size() > 253) pdu.resize(253);
        return pdu;
    }

  private:
    void put(byte_list& to, unsigned v) {
        to.push_back(low_byte(v >> 8));
        to.push_back(low_byte(v));
    }
    // Near a row, mostly one of the table that the function is for.
    unsigned address(unsigned code) {
        if (one_in(30)) return below(65536);
        const char table = code == 2                              ? 'd'
                           : code == 4                            ? 'i'
                           : code == 1 || code == 5 || code == 15 ? 'c'
                                                                  : 'h';
        const auto count = static_cast<unsigned>(device_->rows.size());
        std::size_t at = below(count);
        for (unsigned tries = 0; device_->rows[at].table != table && tries < 20; ++tries) at = below(count);
        return (device_->rows[at].address + below(3) + 65535) % 65536;
    }
    unsigned count() {
        return one_in(30) ? below(65536) : one_in(8) ? below(260) : 1 + below(one_in(2) ? 3 : 14);
    }

    // Values as of the rows from an address on, or near their limits.
    void put_values(byte_list& to, unsigned from, unsigned words) {
        for (unsigned at = from; at < from + words;) {
            const auto r = std::find_if(device_->rows.begin(), device_->rows.end(),
                                        [&](const row& x) { return x.table == 'h' && x.address == at; });
            const unsigned width = r == device_->rows.end() ? 1 : r->words;
            long long v = below(65536);
            if (r != device_->rows.end() && !one_in(60)) {
                const auto span = static_cast<unsigned long long>(r->high - r->low) + 1;
                v = one_in(3) ? (one_in(2) ? r->low : r->high)
                              : r->low + static_cast<long long>(engine_() % span);
                if (one_in(25)) v = one_in(2) ? r->low - 1 : r->high + 1;
            }
            for (unsigned w = 0; w < width && at < from + words; ++w, ++at) {
                const unsigned shift = 16 * (device_->is_low_first ? w : width - 1 - w);
                put(to, static_cast<unsigned>(static_cast<unsigned long long>(v) >> shift & 0xFFFF));
            }
        }
    }

    void fill(byte_list& pdu) {
        const unsigned code = pdu[0];
        const unsigned at = address(code);
        if (code < 5 || code == 15) {
            const unsigned quantity = count();
            put(pdu, at);
            put(pdu, quantity);
            if (code < 5) return;
            const unsigned size = std::min((quantity + 7) / 8, 247u);
            pdu.push_back(low_byte(size));
            for (unsigned i = 0; i < size; ++i) pdu.push_back(low_byte(below(256)));
        } else if (code == 5) {
            put(pdu, at);
            put(pdu, one_in(20) ? below(65536) : one_in(2) ? 0xFF00 : 0);
        } else if (code == 6) {
            put(pdu, at);
            put_values(pdu, at, 1);
        } else if (code == 16 || code == 23) {
            if (code == 23) {
                put(pdu, address(code));
                put(pdu, count());
            }
            const unsigned quantity = std::min(count(), 130u);
            put(pdu, at);
            put(pdu, quantity);
            pdu.push_back(low_byte(2 * quantity));
            put_values(pdu, at, quantity);
        } else if (code == 22) {
            put(pdu, at);
            put(pdu, one_in(2) ? below(65536) : 0xFFFF);
            put(pdu, below(65536));
        } else if (code == 8) {
            put(pdu, one_in(8) ? below(22) : 0);
            for (unsigned i = one_in(10) ? below(126) : 1 + below(3); i != 0; --i) put(pdu, below(65536));
        } else if (code == 43) {
            pdu.push_back(low_byte(one_in(10) ? below(256) : 14));
            pdu.push_back(low_byte(below(6)));
            pdu.push_back(low_byte(one_in(2) ? below(8) : one_in(2) ? 0x80 + below(4) : below(256)));
        } else if (code != 17) {
            for (unsigned i = below(12); i != 0; --i) pdu.push_back(low_byte(below(256)));
        }
    }

    const device* device_;
    dice engine_;
};

} // namespace row_model
