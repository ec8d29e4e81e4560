#include "fastdds_answerer.hpp"

#include <algorithm>
#include <cstdio>
#include <fastdds/dds/subscriber/SampleInfo.hpp>

#include "ending_signals.hpp"

namespace peers {

namespace {

class Answerer final : public dds::DataReaderListener {
  public:
    explicit Answerer(const Exchange& exchange)
        : exchange_(exchange), request_(exchange.request.type->createData()) {}
    ~Answerer() override { exchange_.request.type->deleteData(request_); }
    Answerer(const Answerer&) = delete;
    Answerer& operator=(const Answerer&) = delete;

    void start(Participant& participant) {
        // The writer first: there may be requests as soon as there is a reader.
        if (!is_oneway(exchange_)) {
            writer_ = participant.writer("reply/" + exchange_.key, exchange_.reply);
        }
        reader_ = participant.reader("request/" + exchange_.key, exchange_.request, this);
    }

    bool is_ready() const {
        return has_counterpart(*reader_) && (writer_ == nullptr || has_counterpart(*writer_));
    }

    void on_data_available(dds::DataReader* reader) override {
        dds::SampleInfo info;
        while (reader->take_next_sample(request_, &info) ==
               eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK) {
            if (info.valid_data && writer_ != nullptr) writer_->write(exchange_.reply.sample.get());
        }
    }

  private:
    Exchange exchange_;
    void* request_;
    dds::DataWriter* writer_ = nullptr;
    dds::DataReader* reader_ = nullptr;
};

}  // namespace

void answer_until_signal(const Network& network, const std::vector<Exchange>& exchanges) {
    std::vector<std::unique_ptr<Answerer>> answerers;
    Participant participant{network};
    for (const auto& exchange : exchanges) {
        answerers.push_back(std::make_unique<Answerer>(exchange));
        answerers.back()->start(participant);
    }
    const auto is_ready = [](const auto& answerer) { return answerer->is_ready(); };
    while (!std::all_of(answerers.begin(), answerers.end(), is_ready)) {
        if (ending_signal_within(5)) return;
    }
    std::printf("ready\n");
    std::fflush(stdout);
    wait_for_ending_signal();
}

}  // namespace peers
