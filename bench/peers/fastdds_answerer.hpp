// The server's side over DDS: a reader of requests, whose listener writes the reply.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "fastdds_participant.hpp"

namespace peers {

/// A call as two samples: topics request/KEY and reply/KEY.
struct Exchange {
    std::string key;
    Message request;
    Message reply;  // no sample where it is oneway
};

inline bool is_oneway(const Exchange& exchange) {
    return exchange.reply.sample == nullptr;
}

/// Prints a line when all readers and writers have found the client's, and answers until a signal
/// ends it. The caller has blocked those.
void answer_until_signal(const Network& network, const std::vector<Exchange>& exchanges);

}  // namespace peers
